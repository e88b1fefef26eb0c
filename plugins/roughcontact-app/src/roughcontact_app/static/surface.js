// The surfaces before the solve: their pictures, numbers and warnings.

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

export function showNoSurface(problem) {
  showSurface(NOTHING);
  say("surface-problem", problem);
}
