// The page: what the user changes is sent, checked and shown at once; a run is started and followed.

import { get, post } from "./api.js";
import { MapFile } from "./files.js";
import { byId, say, showList } from "./page.js";
import { follow } from "./run.js";
import { listRuns } from "./runs.js";
import * as settings from "./settings.js";
import { showNoSurface, showRoughness, showSurface } from "./surface.js";
import { isPath, summarize } from "./words.js";

const { form } = settings;
// Milliseconds after the last key until the server is asked.
const DELAY = 350;
// The maps of the body and of the counterbody.
const files = [["", "surface"], ["counterbody_", "counterbody_surface"]].map((of) => new MapFile(...of, () => changed(0), takeFiles));
// The run that is shown, its settings and its phase.
let run = { id: "" };
let starting = false;
let changes = 0;
let timer = 0;

// Of two files that are chosen at once the first is for the body, the second for the counterbody.
function takeFiles(file, chosen) {
  // The same file may be chosen again when it has changed.
  file.input.value = "";
  if (chosen.length > 1) files.forEach((one, index) => one.take(chosen[index]));
  else if (chosen.length) file.take(chosen[0]);
  if (chosen.length > files.length) say("note", `There are two bodies: of these ${chosen.length} files the first two are read.`);
}

const missing = () => files.find((file) => file.isMissing);

// The address holds the shown run only beside the settings that it had.
function remember() {
  const others = Boolean(run.settings) && settings.differ(run.settings);
  byId("stale").hidden = !others;
  history.replaceState(null, "", `#${settings.toFragment(others ? "" : run.id)}`);
}

function changed(delay = DELAY) {
  showForm();
  remember();
  allowSolve();
  clearTimeout(timer);
  // What is shown is old from now on, and answers on their way are dropped.
  changes++;
  document.body.setAttribute("aria-busy", "true");
  timer = setTimeout(refresh, delay);
}

function showForm() {
  settings.showFields(Object.fromEntries(files.map((file) => [file.prefix, file.facts])));
  for (const [group, words] of Object.entries(summarize(settings.read()))) byId(`s-${group}`).textContent = words;
}

function allowSolve() {
  const file = missing();
  byId("solve").disabled = starting || Boolean(file);
  byId("solve").textContent = starting ? "Starting …" : "Solve";
  const why = file?.reading ? `Solve waits until ${file.reading.name} is read.` : "There is no surface to solve: choose another file, or another surface.";
  say("solve-why", file ? why : "");
}

// The surface first, then the plan; an answer to settings that have changed again is dropped.
async function refresh() {
  const change = changes;
  const values = settings.read();
  const file = missing();
  if (file) {
    showNothing(file.reading ? "" : file.unread);
    return;
  }
  settings.markWrong();
  try {
    const surface = await post("api/surface", values);
    if (change !== changes) return;
    showSurface(surface);
    await showPlan(values, change);
    if (change === changes) showRoughness(values, () => change !== changes);
  } catch (error) {
    if (change !== changes) return;
    showNothing(error.message);
    settings.markWrong(error);
    // Its group may be closed, or out of view.
    byId("plan").textContent = error.message;
  } finally {
    if (change === changes) document.body.removeAttribute("aria-busy");
  }
}

function showNothing(problem) {
  document.body.removeAttribute("aria-busy");
  showNoSurface(problem);
  showNoPlan("");
}

function showNoPlan(why) {
  byId("plan").textContent = why;
  showList(byId("plan-warnings"), []);
  byId("plan-basis").textContent = byId("plan-text").textContent = "";
}

async function showPlan(values, change) {
  let plan;
  try {
    plan = await post("api/plan", values);
  } catch (error) {
    if (change !== changes) return;
    showNoPlan(error.message);
    settings.markWrong(error);
    return;
  }
  if (change !== changes) return;
  const solves = values.load === "film" ? "separations" : plan.solves > plan.loads.length || isPath(values) ? "states" : "loads";
  const loads = plan.solves > 1 ? `${plan.solves} ${solves}, about` : "About";
  byId("plan").textContent = `${loads} ${duration(plan.seconds)} for the solve, ${plan.memory}.`;
  byId("plan-basis").textContent = plan.basis;
  byId("plan-text").textContent = plan.text;
  showList(byId("plan-warnings"), plan.warnings);
}

function duration(seconds) {
  if (seconds < 60) return `${seconds.toPrecision(1)} s`.replace(/^(\d)e\+1 s/, "$10 s");
  return seconds < 3600 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

function solve(event) {
  event.preventDefault();
  return start(true);
}

// Leads to its answer if somebody has asked for it.
async function start(leads) {
  if (starting || missing()) return;
  say("refusal", "");
  starting = true;
  allowSolve();
  try {
    showRun(await post("api/runs", settings.read()), leads);
  } catch (error) {
    say("refusal", error.message);
    settings.markWrong(error);
  } finally {
    starting = false;
    allowSolve();
  }
}

function showRun(state, leads = true) {
  run = state;
  byId("unsolved").hidden = true;
  remember();
  follow(run.id, noteRun, leads);
  listRuns(run.id, showRun);
}

function noteRun(state) {
  const isNews = state.phase !== run.phase;
  run = state;
  remember();
  if (isNews) listRuns(run.id, showRun);
}

async function restore(found) {
  settings.write(found.values);
  say("boundary-note", "");
  // Which files are wanted follows from what is shown.
  settings.showFields({});
  const wishes = [];
  for (const file of files) wishes.push(await file.restore());
  if (found.run) showRun({ id: found.run }, false);
  else if (!run.id) showNoRun();
  changed(0);
  return ["The settings are restored.", ...wishes].filter(Boolean).join(" ");
}

function showNoRun() {
  byId("run").hidden = true;
  byId("unsolved").hidden = false;
}

// Without a link the page has a scene of its own, with its answer: that of a run before, if there is one.
async function openFirst() {
  showForm();
  const { runs } = await get("api/runs");
  const scheme = settings.read().scheme;
  const known = runs.find((one) => one.phase === "done" && one.settings.scheme === scheme && !settings.differ(one.settings));
  if (known) showRun(known, false);
  else await start(false);
  if (!run.id) showNoRun();
  changed(0);
}

// The link is in the address.
async function restoreAddress() {
  if (location.hash.length < 2) {
    await openFirst();
    return;
  }
  const found = settings.fromFragment(location.hash);
  if (found.problem) {
    showNoRun();
    changed(0);
  } else await restore(found);
  say("note", found.problem);
}

async function restoreLink(event) {
  event.preventDefault();
  const text = byId("link").value;
  const found = text.trim() ? settings.fromFragment(text) : { problem: "Paste a link first." };
  say("link-problem", found.problem);
  if (!found.problem) say("note", await restore(found));
}

function listen() {
  form.addEventListener("submit", solve);
  byId("restore-form").addEventListener("submit", restoreLink);
  form.addEventListener("input", (event) => {
    if (event.target.tagName !== "INPUT" || !event.target.name) return;
    say("note", "");
    changed();
  });
  form.addEventListener("change", (event) => {
    if (event.target.tagName !== "SELECT") return;
    const { name } = event.target;
    // What was changed for the user is said until he changes it, whatever else he sets meanwhile.
    if (name === "surface" || name === "boundary") say("boundary-note", name === "surface" ? settings.surfaceKindChanged() : "");
    const said = name === "load" && settings.loadKindChanged();
    if (said) say("boundary-note", said);
    say("note", "");
    changed();
  });
  byId("roughness").addEventListener("toggle", () => {
    const change = changes;
    showRoughness(settings.read(), () => change !== changes);
  });
  byId("copy").addEventListener("click", async () => {
    const link = `${location.href.split("#")[0]}#${settings.toFragment("")}`;
    try {
      await navigator.clipboard.writeText(link);
      say("note", "The link is copied.");
    } catch {
      say("note", link);
    }
  });
  window.addEventListener("hashchange", restoreAddress);
  settings.darkness.addEventListener("change", () => changed(0));
  let depth = 0;
  addEventListener("dragenter", () => { byId("veil").hidden = ++depth === 0; });
  addEventListener("dragleave", () => { byId("veil").hidden = --depth <= 0; });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    depth = 0;
    byId("veil").hidden = true;
    const file = files[event.target.closest?.("#g-counterbody") ? 1 : 0];
    takeFiles(file, [...(event.dataTransfer?.files || [])]);
  });
}

async function begin() {
  try {
    const start = await get("api/start");
    settings.prepare(start);
    for (const file of files) file.input.accept = start.endings.join(",");
  } catch (error) {
    showNoSurface(error.message);
    return;
  }
  listen();
  await restoreAddress();
  listRuns(run.id, showRun);
  document.body.dataset.ready = "true";
}

begin();
