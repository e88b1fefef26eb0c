// One run: its progress, its answer, its pictures and files.

import { get, post } from "./api.js";
import { byId, element, say, showList } from "./page.js";
import { ENDED } from "./runs.js";
import { describe, isPath, subjectOf } from "./settings.js";
import { States } from "./states.js";
import { Viewer } from "./viewer.js";

const PHASES = {
  waiting: "Waiting", starting: "Starting", preparing: "Preparing", solving: "Solving", evaluating: "Evaluating",
  drawing: "Drawing", done: "Done", failed: "Failed", cancelled: "Cancelled",
};
// Loads without a value of their own.
const CYCLES = ["cycle", "fretting"];
// The quantity that a kind of load gives.
const GIVEN = { pressure: "mean pressure", force: "force", approach: "approach" };
let viewer;
let states;
let shown = {};

export function follow(run, onChange) {
  viewer ??= new Viewer(byId("picture"), "Picture of the answer");
  states ??= new States(viewer);
  shown = { panel: "", phase: "", answers: 0, outputs: -1 };
  byId("run").hidden = false;
  for (const name of ["answer", "run-problem", "run-subject", "progress"]) byId(name).hidden = true;
  byId("panel-buttons").dataset.run = "";
  viewer.hide();
  states.hide();
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
  if (text) byId("progress").hidden = true;
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
  if (state.answers.length && !shown.answers) renderAnswer(state);
  if (state.outputs.length !== shown.outputs || state.phase !== shown.phase) renderOutputs(state);
  showList(byId("run-notes"), state.notes);
  Object.assign(shown, { phase: state.phase, answers: state.answers.length, outputs: state.outputs.length });
}

const quantity = (answer, name) => answer.quantities.find((one) => one.name === name);

function renderAnswer(state) {
  const many = state.answers.length > 1;
  byId("answer").hidden = false;
  const [first] = state.answers;
  const percent = (answer) => `${(100 * quantity(answer, "contact area fraction").value).toPrecision(3)} % of nominal`;
  const { load } = state.settings;
  byId("headline").textContent = load === "fretting"
    ? `Energy lost in a cycle ${quantity(first, "energy lost in a cycle").text}`
    : load === "cycle"
    ? `Pull-off ${quantity(first, "pull-off").text}; energy lost in the cycle ${quantity(first, "energy lost").text}`
    : isPath(state.settings)
    ? `${state.answers.length} states of the path; at the end a contact area of ${percent(state.answers.at(-1))}`
    : many
    ? `${state.answers.length} loads solved`
    : `Contact area ${quantity(first, "contact area").text}; ${percent(first)}`;
  const failed = state.answers.filter((answer) => !answer.certified);
  const statuses = [...new Set((failed.length ? failed : state.answers).map((answer) => answer.status))];
  byId("verdict").textContent = `${statuses.join("; ")}. The value after ± is one standard deviation.`;
  byId("verdict").className = failed.length ? "alert" : "";
  const { load: place, places } = state.answers.at(-1);
  say("places", places && `Other places of the surface${many ? `, at ${place}` : ""}: ${places}`);
  showList(byId("warnings"), state.warnings);
  byId("answer-table").replaceChildren(...(many ? curveRows(state) : singleRows(first)));
  byId("h-answer").focus({ preventScroll: true });
  byId("run").scrollIntoView({ block: "start" });
}

function singleRows(answer) {
  const rows = answer.quantities.map((one) => {
    const row = element("tr");
    row.append(element("th", one.name, { scope: "row" }), element("td", one.text, { "data-quantity": one.name }));
    row.lastChild.dataset.value = one.value;
    return row;
  });
  return [element("caption", "The answer", { class: "unseen" }), body(rows)];
}

function body(rows) {
  const made = element("tbody");
  made.append(...rows);
  return made;
}

// The number of a text, and its unit, which is that of its whole column.
function split({ text, unit }) {
  const end = unit ? text.lastIndexOf(" ") : text.length;
  return [text.slice(0, end), text.slice(end + 1)];
}

function curveRows(state) {
  const names = state.answers[0].quantities.map((one) => one.name);
  const order = ["mean pressure", "force", ...names.filter((name) => !["mean pressure", "force"].includes(name))];
  const head = element("tr");
  const titles = order.map((name) => [name, split(quantity(state.answers[0], name))[1]].filter(Boolean).join(", "));
  head.append(...[...titles, "fields"].map((title) => element("th", title, { scope: "col" })));
  const rows = state.answers.map((answer, index) => {
    const row = element("tr");
    for (const name of order) {
      const one = quantity(answer, name);
      const [number] = split(one);
      // A load stands as it was given.
      const isShort = one.uncertainty || name === GIVEN[state.settings.load] || !Number.isFinite(Number(number));
      row.append(element("td", isShort ? number : String(Number(Number(number).toPrecision(3))), { "data-quantity": name }));
      row.lastChild.dataset.value = one.value;
    }
    row.append(element("td", "", { "data-files": index }));
    return row;
  });
  const top = element("thead");
  top.append(head);
  return [element("caption", isPath(state.settings) ? "The answers, a row for each state" : "The answers, a row for each load", { class: "unseen" }), top, body(rows)];
}

function fileLink(state, output, text, main = false) {
  const address = `runs/${state.id}/${output.file}`;
  const { load, loads, load_unit: unit } = state.settings;
  const what = CYCLES.includes(load) ? "" : `-${loads}-${unit}`;
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
  if (of("path")) links.push(fileLink(state, of("path"), "Path (.npz)"));
  if (of("animation")) links.push(fileLink(state, of("animation"), "Moving picture (.gif)"));
  if (!many && of("solution")) links.push(fileLink(state, of("solution"), "Fields (.npz)"));
  keepOrReplace(byId("downloads"), links);
  for (const cell of byId("answer-table").querySelectorAll("[data-files]")) {
    const load = Number(cell.dataset.files);
    if (of("solution", load)) cell.replaceChildren(fileLink(state, of("solution", load), ".npz", null));
  }
  renderPictures(state);
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

function renderPictures(state) {
  const pictures = state.outputs.filter((one) => one.role === "picture");
  const place = byId("panel-buttons");
  for (const output of pictures.slice(place.dataset.run === state.id ? place.children.length : 0)) {
    if (place.dataset.run !== state.id) {
      place.replaceChildren();
      place.dataset.run = state.id;
    }
    const button = element("button", output.panel.replaceAll("-", " "), { type: "button", "aria-pressed": "false" });
    button.addEventListener("click", () => choosePicture(state, output, button));
    place.append(button);
    if (place.children.length === 1) choosePicture(state, output, button);
  }
  if (!pictures.length) place.replaceChildren();
  place.hidden = pictures.length < 2;
}

function choosePicture(state, output, button) {
  for (const other of byId("panel-buttons").children) other.setAttribute("aria-pressed", String(other === button));
  if (output.states) {
    states.show(state.id, output);
    return;
  }
  states.hide();
  viewer.show(`runs/${state.id}/${output.file}`, `The ${output.panel.replaceAll("-", " ")} of this contact`);
}
