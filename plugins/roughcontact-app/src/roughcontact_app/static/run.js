// One run: its progress, its answer, its pictures and files.

import { CYCLES, renderAnswer } from "./answer.js";
import { get, post } from "./api.js";
import { byId, element, say, showList } from "./page.js";
import { Pictures } from "./pictures.js";
import { ENDED } from "./runs.js";
import { describe, subjectOf } from "./words.js";

const PHASES = {
  waiting: "Waiting", starting: "Starting", preparing: "Preparing", solving: "Solving", evaluating: "Evaluating",
  drawing: "Drawing", done: "Done", failed: "Failed", cancelled: "Cancelled",
};
let pictures;
// Whether somebody waits for the answer, and is led to it.
let isAwaited = false;
let shown = {};

export function follow(run, onChange, leads) {
  pictures ??= new Pictures();
  isAwaited = leads;
  shown = { phase: "", answers: 0, outputs: -1 };
  byId("run").hidden = false;
  for (const name of ["answer", "run-problem", "run-subject", "progress"]) byId(name).hidden = true;
  byId("awaited").hidden = false;
  pictures.hide();
  byId("cancel").onclick = () => post(`api/cancel/${run}`, {}).catch(() => {});
  poll(run, onChange);
}

// The server answers when the phase has changed since a version, or after half a second.
async function poll(run, onChange, after = "") {
  const mine = shown;
  let state;
  try {
    state = await get(`runs/${run}?after=${after}`);
  } catch (error) {
    if (mine === shown) problem(error.message);
    return;
  }
  if (mine !== shown) return;
  render(state);
  onChange(state);
  if (!ENDED.includes(state.phase)) poll(run, onChange, state.version);
}

function problem(text) {
  byId("run-problem").hidden = !text;
  byId("run-problem").textContent = text;
  for (const name of text ? ["progress", "awaited"] : []) byId(name).hidden = true;
}

function render(state) {
  const ended = ENDED.includes(state.phase);
  byId("progress").hidden = ended;
  const bar = byId("bar");
  if (["waiting", "starting", "preparing"].includes(state.phase)) bar.removeAttribute("value");
  else bar.value = state.fraction;
  say("run-subject", `Run ${state.number}: ${describe(state.settings)}.`);
  byId("phase").textContent = `${PHASES[state.phase]}, ${state.seconds.toFixed(0)} s. ${state.text}`;
  if (state.phase !== shown.phase) byId("live").textContent = `${PHASES[state.phase]}. ${ended ? "" : state.text}`;
  problem(state.phase === "failed" ? state.error : state.phase === "cancelled" ? "The run was cancelled." : "");
  if (state.answers.length && !shown.answers) showAnswer(state);
  const isNew = ["outputs", "answers"].some((name) => state[name].length !== shown[name]);
  if (isNew || state.phase !== shown.phase) renderOutputs(state);
  showList(byId("run-notes"), state.notes);
  Object.assign(shown, { phase: state.phase, answers: state.answers.length, outputs: state.outputs.length });
}

function showAnswer(state) {
  byId("awaited").hidden = true;
  renderAnswer(state);
  if (!isAwaited) return;
  byId("h-answer").focus({ preventScroll: true });
  byId("run").scrollIntoView({ block: "start" });
}

function fileLink(state, output, text, main = false) {
  const address = `runs/${state.id}/${output.file}`;
  const { load, loads, load_unit: unit } = state.settings;
  const what = [...CYCLES, "film"].includes(load) ? "" : `-${loads}-${unit}`;
  const run = `${subjectOf(state.settings).replace(/\.[^.]*$/, "")}${what}`;
  const link = element("a", text, { href: address, download: `${run.replace(/[^\p{L}\p{N}.]+/gu, "-")}-${output.file}` });
  if (main !== null) link.className = main ? "button main" : "button";
  return link;
}

function renderOutputs(state) {
  const of = (role, load) => state.outputs.find((one) => one.role === role && (load === undefined || one.load === load));
  const links = [];
  const many = state.answers.length > 1;
  if (of("report")) {
    links.push(fileLink(state, of("report"), "Download the report", true));
    links.push(element("a", "Open the report", {
      href: `runs/${state.id}/${of("report").file}`, target: "_blank", rel: "noopener", class: "button",
    }));
  }
  // It keeps the place of the report, so that nothing jumps away under the pointer.
  else if (!ENDED.includes(state.phase)) links.push(element("span", "The report follows", { class: "button", "aria-disabled": "true" }));
  if (of("table")) links.push(fileLink(state, of("table"), "Table (.csv)"));
  if (of("json")) links.push(fileLink(state, of("json"), "Table (.json)"));
  if (of("comsol")) links.push(fileLink(state, of("comsol"), "For COMSOL (.txt)"));
  if (of("path")) links.push(fileLink(state, of("path"), "Path (.npz)"));
  if (of("animation")) links.push(fileLink(state, of("animation"), "Moving picture (.gif)"));
  if (!many && of("solution")) links.push(fileLink(state, of("solution"), "Fields (.npz)"));
  keepOrReplace(byId("downloads"), links);
  for (const cell of byId("answer-table").querySelectorAll("[data-files]")) {
    const load = Number(cell.dataset.files);
    if (of("solution", load)) cell.replaceChildren(fileLink(state, of("solution", load), ".npz", null));
  }
  for (const cell of byId("answer-table").querySelectorAll("[data-text]")) {
    const text = state.outputs.find((one) => one.role === "text" && one.column === cell.dataset.text);
    if (text) {
      cell.replaceChildren(fileLink(state, text, ".txt", null));
      cell.firstChild.setAttribute("aria-label", `${text.column} over the separation (.txt)`);
    }
  }
  if (state.answers.length) pictures.show(state);
}

// A link that somebody is about to click, or that has the focus, stays the same one.
function keepOrReplace(place, links) {
  const key = (link) => `${link.href} ${link.textContent}`;
  const known = new Map([...place.children].map((link) => [key(link), link]));
  const focused = document.activeElement;
  if (links.length === known.size && links.every((link) => known.has(key(link)))) return;
  place.replaceChildren(...links.map((link) => known.get(key(link)) || link));
  if (place.contains(focused)) focused.focus();
}
