// The page: what the user changes is sent, checked and shown at once; a run is started and followed.

import { get, post, upload } from "./api.js";
import { element, follow, showList, subjectOf } from "./run.js";
import * as settings from "./settings.js";
import { Viewer } from "./viewer.js";

const byId = (name) => document.getElementById(name);
const { form } = settings;
// Milliseconds after the last key until the server is asked.
const DELAY = 350;
let facts = null;
let run = "";
let changes = 0;
let timer = 0;
let viewer;
const runs = new Map();

function say(place, text) {
  byId(place).hidden = !text;
  byId(place).textContent = text;
}

function remember() {
  history.replaceState(null, "", `#${settings.toFragment(run)}`);
}

function changed(delay = DELAY) {
  settings.showFields(facts);
  remember();
  clearTimeout(timer);
  timer = setTimeout(refresh, delay);
}

// The surface first, then the plan; an answer to settings that have changed again is dropped.
async function refresh() {
  const change = ++changes;
  const values = settings.read();
  document.body.setAttribute("aria-busy", "true");
  try {
    const surface = await post("api/surface", values);
    if (change !== changes) return;
    showSurface(surface);
    await showPlan(values, change);
  } catch (error) {
    if (change !== changes) return;
    say("surface-problem", error.message);
    showList(byId("surface-warnings"), []);
    byId("surface-table").tBodies[0].replaceChildren();
    byId("surface-history").textContent = "";
    viewer.hide();
    byId("plan").textContent = "";
  } finally {
    if (change === changes) document.body.removeAttribute("aria-busy");
  }
}

function showSurface(surface) {
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

async function showPlan(values, change) {
  let plan;
  try {
    plan = await post("api/plan", values);
  } catch (error) {
    if (change !== changes) return;
    byId("plan").textContent = error.message;
    byId("plan-text").textContent = "";
    return;
  }
  if (change !== changes) return;
  const loads = plan.loads.length > 1 ? `${plan.loads.length} loads, ` : "";
  byId("plan").textContent = `${loads}about ${duration(plan.seconds)} for the solve, ${plan.memory}. ${plan.basis}`;
  byId("plan-text").textContent = plan.text;
}

function duration(seconds) {
  if (seconds < 60) return `${seconds.toPrecision(1)} s`.replace(/^(\d)e\+1 s/, "$10 s");
  return seconds < 3600 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

async function takeFile(file) {
  say("refusal", "");
  const wanted = settings.read();
  say("file-shown", `Reading ${file.name} ...`);
  try {
    const found = await upload(file);
    facts = found.facts;
    settings.setFile(found.digest, found.name);
    form.elements.surface.value = "file";
    const other = wanted.file && wanted.surface === "file" && wanted.file !== found.digest && wanted.file_name;
    showFile(found, other ? ` It is not the file of the link, ${wanted.file_name}, whose digest begins ${wanted.file.slice(0, 12)}.` : "");
    if (wanted.surface !== "file") settings.surfaceKindChanged();
    changed(0);
  } catch (error) {
    say("file-shown", "");
    say("surface-problem", error.message);
    viewer.hide();
    showList(byId("surface-warnings"), []);
    byId("surface-table").tBodies[0].replaceChildren();
  }
}

function showFile(found, more = "") {
  const cells = found.facts ? `, ${found.facts.shape.join(" x ")} points` : "";
  say("file-shown", `${found.name}${cells}, digest ${found.digest.slice(0, 12)}.${more}`);
}

async function solve(event) {
  event.preventDefault();
  say("refusal", "");
  byId("solve").disabled = true;
  try {
    const state = await post("api/runs", settings.read());
    showRun(state.id, state.settings);
  } catch (error) {
    say("refusal", error.message);
  } finally {
    byId("solve").disabled = false;
  }
}

function showRun(id) {
  run = id;
  remember();
  follow(id, listRun);
}

function listRun(state) {
  const text = `${subjectOf(state.settings)}, ${state.settings.load} ${state.settings.loads} ${state.settings.load_unit}: ${state.phase}`;
  if (runs.get(state.id) === text) return;
  runs.set(state.id, text);
  byId("runs").hidden = runs.size < 2;
  const items = [...runs].map(([id, label]) => {
    const button = element("button", label, { type: "button", "aria-pressed": String(id === run) });
    button.addEventListener("click", () => showRun(id));
    const item = element("li");
    item.append(button);
    return item;
  });
  byId("run-list").replaceChildren(...items);
}

async function restore(text) {
  const found = settings.fromFragment(text);
  settings.write(found.values);
  facts = null;
  say("file-shown", "");
  const { surface, file, file_name: name } = settings.read();
  if (surface === "file" && file) {
    const known = await post("api/file", file).catch(() => ({ here: false }));
    facts = known.facts || null;
    if (known.here) showFile(known);
    else say("file-shown", `Choose or drop the file of this link again: ${name}, digest ${file.slice(0, 12)}.`);
  }
  run = found.run;
  changed(0);
  if (run) follow(run, listRun);
}

function listen() {
  form.addEventListener("submit", solve);
  form.addEventListener("input", (event) => {
    if (event.target.tagName === "INPUT" && event.target.name) changed();
  });
  form.addEventListener("change", (event) => {
    if (event.target.tagName !== "SELECT") return;
    if (event.target.name === "load") settings.loadKindChanged();
    if (event.target.name === "surface") settings.surfaceKindChanged();
    changed();
  });
  byId("file-input").addEventListener("change", (event) => {
    if (event.target.files.length) takeFile(event.target.files[0]);
  });
  byId("copy").addEventListener("click", async () => {
    const link = `${location.href.split("#")[0]}#${settings.toFragment("")}`;
    try {
      await navigator.clipboard.writeText(link);
      byId("note").textContent = "The link is copied.";
    } catch {
      byId("note").textContent = link;
    }
  });
  byId("restore").addEventListener("click", () => restore(byId("link").value));
  window.addEventListener("hashchange", () => restore(location.hash));
  settings.darkness.addEventListener("change", () => changed(0));
  let depth = 0;
  addEventListener("dragenter", () => { byId("veil").hidden = ++depth === 0; });
  addEventListener("dragleave", () => { byId("veil").hidden = --depth <= 0; });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    depth = 0;
    byId("veil").hidden = true;
    if (event.dataTransfer?.files.length) takeFile(event.dataTransfer.files[0]);
  });
}

async function begin() {
  viewer = new Viewer(byId("surface-picture"), "Picture of the surface");
  try {
    const start = await get("api/start");
    settings.prepare(start.defaults, start.examples);
    byId("file-input").accept = start.endings.join(",");
  } catch (error) {
    say("surface-problem", error.message);
    return;
  }
  listen();
  await restore(location.hash);
  document.body.dataset.ready = "true";
}

begin();
