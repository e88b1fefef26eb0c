// The runs that the server keeps, numbered in the order of their starts; the one that is shown is marked.

import { get } from "./api.js";
import { byId, element } from "./page.js";
import { describe } from "./settings.js";

export const ENDED = ["done", "failed", "cancelled"];
// Milliseconds between two looks at runs that have not ended.
const INTERVAL = 2000;
const buttons = new Map();
let current = "";
let timer = 0;

// Marks a run at once; choose is called with another one that is wanted.
export async function listRuns(run, choose) {
  current = run;
  clearTimeout(timer);
  mark();
  let runs;
  try {
    ({ runs } = await get("api/runs"));
  } catch {
    return;
  }
  for (const [id, button] of buttons) if (!runs.some((one) => one.id === id)) drop(id, button);
  for (const one of runs) {
    if (!buttons.has(one.id)) addButton(one, choose);
    const text = `Run ${one.number}: ${describe(one.settings)}; ${one.phase}`;
    if (buttons.get(one.id).textContent !== text) buttons.get(one.id).textContent = text;
  }
  mark();
  clearTimeout(timer);
  if (runs.some((one) => !ENDED.includes(one.phase))) timer = setTimeout(() => listRuns(current, choose), INTERVAL);
}

function addButton(one, choose) {
  const button = element("button", "", { type: "button" });
  button.addEventListener("click", () => choose(one));
  const item = element("li");
  item.append(button);
  byId("run-list").append(item);
  buttons.set(one.id, button);
}

// The server forgets the oldest ones.
function drop(id, button) {
  button.parentElement.remove();
  buttons.delete(id);
}

function mark() {
  for (const [id, button] of buttons) button.setAttribute("aria-pressed", String(id === current));
  byId("runs").hidden = [...buttons.keys()].every((id) => id === current);
}
