// The surfaces before the solve: their pictures, numbers and warnings.

import { post } from "./api.js";
import { byId, element, say, showList } from "./page.js";
import { Viewer } from "./viewer.js";

const viewers = {
  surface: new Viewer(byId("surface-picture"), "Picture of the surface"),
  counterbody: new Viewer(byId("counterbody-picture"), "Picture of the counterbody"),
};
const NOTHING = { warnings: [], rows: [], history: [] };

export function showSurface(surface) {
  say("surface-problem", "");
  show("surface", surface);
  show("counterbody", surface.counterbody || NOTHING);
  byId("counterbody-shown").hidden = !surface.counterbody;
}

function show(place, { warnings, rows, history, note = "", picture = "" }) {
  showList(byId(`${place}-warnings`), warnings);
  const lines = rows.map(([name, text]) => {
    const row = element("tr");
    row.append(element("th", name, { scope: "row" }), element("td", text));
    return row;
  });
  byId(`${place}-table`).tBodies[0].replaceChildren(...lines);
  byId(`${place}-history`).textContent = [...history, note].filter(Boolean).join("; ");
  if (picture) viewers[place].show(`pictures/${picture}`, `Heights of the ${place}`);
  else viewers[place].hide();
}

// It takes seconds: only while it is open. What is shown of a surface that has changed goes at once.
export async function showRoughness(values, isLate) {
  if (!byId("roughness").open) return;
  const show = ({ rows = [], notes = [], pictures = [], basis = "" }) => {
    byId("roughness-basis").textContent = basis;
    showList(byId("roughness-notes"), notes);
    const lines = rows.map(([symbol, meaning, text]) => {
      const row = element("tr");
      row.append(element("th", symbol, { scope: "row" }), element("td", meaning), element("td", text, { "data-texture": symbol }));
      return row;
    });
    byId("roughness-table").tBodies[0].replaceChildren(...lines);
    byId("roughness-pictures").replaceChildren(...pictures.map(({ panel, picture }) =>
      element("img", "", { src: `pictures/${picture}`, alt: `The ${panel.replaceAll("-", " ")} of the surface` })));
  };
  say("roughness-problem", "");
  show({ basis: "measuring" });
  try {
    const found = await post("api/roughness", values);
    if (!isLate()) show({ ...found, basis: `± is one standard deviation from the sampling, ${found.basis}` });
  } catch (error) {
    if (isLate()) return;
    show({});
    say("roughness-problem", error.message);
  }
}

export function showNoSurface(problem) {
  showSurface(NOTHING);
  say("surface-problem", problem);
}
