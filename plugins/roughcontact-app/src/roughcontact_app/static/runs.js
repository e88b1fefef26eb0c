// The runs that the server keeps, in a table by the order of their starts; two of them may stand side by side.

import { get } from "./api.js";
import { byId, element } from "./page.js";
import { describe } from "./words.js";

export const ENDED = ["done", "failed", "cancelled"];
// Milliseconds between two looks at runs that have not ended.
const INTERVAL = 2000;
const rows = new Map();
let runs = [];
let current = "";
let other = "";
let timer = 0;

// Marks a run at once; choose is called with another one that is wanted.
export async function listRuns(run, choose) {
  current = run;
  clearTimeout(timer);
  mark();
  try {
    ({ runs } = await get("api/runs"));
  } catch {
    return;
  }
  // The server forgets the oldest ones.
  for (const [id, row] of rows) {
    if (runs.some((one) => one.id === id)) continue;
    row.remove();
    rows.delete(id);
  }
  const parts = runs.map((one) => describe(one.settings).split(", "));
  runs.forEach((one, index) => {
    if (!rows.has(one.id)) addRow(one, choose);
    const own = parts[index].filter((text) => !parts.every((texts) => texts.includes(text)));
    const { "contact area": area = "", "maximum pressure": peak = "" } = one.numbers;
    const texts = [own.join(", ") || parts[index][0], area, peak, one.phase];
    // A button that somebody is about to click stays the same one.
    texts.forEach((text, column) => {
      const cell = rows.get(one.id).cells[column + 1];
      if (cell.textContent !== text) cell.textContent = text;
    });
  });
  mark();
  clearTimeout(timer);
  if (runs.some((one) => !ENDED.includes(one.phase))) timer = setTimeout(() => listRuns(current, choose), INTERVAL);
}

function addRow(one, choose) {
  const row = element("tr");
  const shown = element("button", `Run ${one.number}`, { type: "button" });
  shown.addEventListener("click", () => choose(one));
  const beside = element("button", "beside", { type: "button", "aria-label": `Run ${one.number} beside the one that is shown` });
  beside.addEventListener("click", () => {
    other = other === one.id ? "" : one.id;
    mark();
  });
  const cells = ["th", "td", "td", "td", "td", "td"].map((name) => element(name));
  cells[0].scope = "row";
  cells[0].append(shown);
  cells[5].append(beside);
  row.append(...cells);
  byId("run-list").append(row);
  rows.set(one.id, row);
}

function mark() {
  for (const [id, { cells }] of rows) {
    cells[0].firstChild.setAttribute("aria-pressed", String(id === current));
    cells[5].firstChild.setAttribute("aria-pressed", String(id === other));
    cells[5].firstChild.hidden = id === current;
  }
  byId("runs").hidden = [...rows.keys()].every((id) => id === current);
  showBeside();
}

function showBeside() {
  const pair = [current, other].map((id) => runs.find((one) => one.id === id));
  byId("beside").hidden = current === other || !pair.every(Boolean);
  if (byId("beside").hidden) return;
  const row = (kind, head, texts) => {
    const made = element("tr");
    made.append(element("th", head, { scope: "row" }), ...texts.map((text) => element(kind, text)));
    return made;
  };
  const names = new Set(pair.flatMap((one) => Object.keys(one.numbers)));
  byId("beside").replaceChildren(
    element("caption", "Two runs side by side", { class: "unseen" }),
    row("th", "", pair.map((one) => `Run ${one.number}`)),
    row("td", "what", pair.map((one) => describe(one.settings))),
    ...[...names].map((name) => row("td", name, pair.map((one) => one.numbers[name] || "–"))),
  );
}
