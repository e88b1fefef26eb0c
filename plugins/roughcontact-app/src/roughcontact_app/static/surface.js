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
  // They are said in the group, which may be closed.
  byId(`m-${place}`).textContent = warnings.length ? `${warnings.length} warning${warnings.length > 1 ? "s" : ""}` : "";
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
  const show = (basis, surfaces = []) => {
    byId("roughness-basis").textContent = basis;
    byId("roughness-surfaces").replaceChildren(...surfaces.map((one) => describeRoughness(one, surfaces.length > 1)));
  };
  say("roughness-problem", "");
  show("measuring");
  try {
    const { surfaces } = await post("api/roughness", values);
    if (!isLate()) show("± is one standard deviation from the sampling.", surfaces);
  } catch (error) {
    if (isLate()) return;
    show("");
    say("roughness-problem", error.message);
  }
}

function describeRoughness({ of, rows, notes, pictures, basis }, several) {
  const made = element("div", "", { "data-roughness": of });
  if (several) made.append(element("h3", `Roughness of the ${of}`));
  made.append(element("p", `${basis[0].toUpperCase()}${basis.slice(1)}.`, { class: "help" }));
  const region = element("div", "", { class: "scroll", tabindex: "0", role: "region", "aria-label": `Numbers of the roughness of the ${of}` });
  const table = element("table");
  table.append(...rows.map(([symbol, meaning, text]) => {
    const row = element("tr");
    row.append(element("th", symbol, { scope: "row" }), element("td", meaning), element("td", text, { "data-texture": symbol }));
    return row;
  }));
  region.append(table);
  const list = element("ul", "", { class: "warnings" });
  showList(list, notes);
  const drawn = element("div", "", { class: "pictures" });
  drawn.append(...pictures.map(({ panel, picture }) =>
    element("img", "", { src: `pictures/${picture}`, alt: `The ${panel.replaceAll("-", " ")} of the ${of}` })));
  made.append(region, list, drawn);
  return made;
}

export function showNoSurface(problem) {
  showSurface(NOTHING);
  say("surface-problem", problem);
  if (problem) byId("g-surface").open = true;
}
