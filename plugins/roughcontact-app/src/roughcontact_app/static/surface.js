// The surface before the solve: its picture, numbers and warnings.

import { byId, element, say, showList } from "./page.js";
import { Viewer } from "./viewer.js";

const viewer = new Viewer(byId("surface-picture"), "Picture of the surface");

export function showSurface(surface) {
  say("surface-problem", "");
  showList(byId("surface-warnings"), surface.warnings);
  const rows = surface.rows.map(([name, text]) => {
    const row = element("tr");
    row.append(element("th", name, { scope: "row" }), element("td", text));
    return row;
  });
  byId("surface-table").tBodies[0].replaceChildren(...rows);
  byId("surface-history").textContent = [...surface.history, surface.note || ""].filter(Boolean).join("; ");
  if (surface.picture) viewer.show(`pictures/${surface.picture}`, "Heights of the surface");
  else viewer.hide();
}

export function showNoSurface(problem) {
  showSurface({ warnings: [], rows: [], history: [] });
  say("surface-problem", problem);
}
