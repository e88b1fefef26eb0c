// The form, its dependent fields, and the link that holds it.

import { fill, makeFields, OTHER, setText, showPresets, textOf, UNITS } from "./fields.js";
import { element } from "./page.js";

export const form = document.getElementById("settings");
// At first for each kind of load: a value and its unit.
const FIRST_LOADS = { pressure: ["100", "MPa"], force: ["5", "N"], approach: ["0.1", "um"], cycle: ["100", "MPa"], fretting: ["100", "MPa"], film: ["100", "MPa"] };
let defaults = {};
let first = {};

export const darkness = matchMedia("(prefers-color-scheme: dark)");

// What the page opens with differs from the defaults of the server, which a link can omit.
export function prepare(start) {
  makeFields(start);
  ({ defaults } = start);
  first = { ...defaults, ...start.first };
  write(first);
}

const hidden = { file: "", file_name: "", [`${OTHER}file`]: "", [`${OTHER}file_name`]: "" };

// Whether a map in a file is solved; what is not shown is not.
export const isFile = (kind) => form.elements[kind].value === "file" && !form.elements[kind].closest("[hidden]");

export function read() {
  const found = { ...hidden, scheme: darkness.matches ? "dark" : "light" };
  for (const name of Object.keys(defaults)) {
    const control = form.elements[name];
    if (control) found[name] = textOf(control);
  }
  return found;
}

export function write(values) {
  const all = { ...defaults, ...values };
  fill(form.elements.load_unit, UNITS[all.load] || UNITS.pressure);
  for (const [name, value] of Object.entries(all)) {
    if (name in hidden) hidden[name] = value;
    else if (form.elements[name]) setText(form.elements[name], value);
  }
}

export function setFile(prefix, digest, name) {
  Object.assign(hidden, { [`${prefix}file`]: digest, [`${prefix}file_name`]: name });
}

// Returns what to say of it: a film law needs a domain that repeats.
export function loadKindChanged() {
  const { load: { value: kind }, boundary } = form.elements;
  fill(form.elements.load_unit, UNITS[kind]);
  [form.elements.loads.value, form.elements.load_unit.value] = FIRST_LOADS[kind];
  if (kind !== "film" || boundary.value === "periodic") return "";
  const before = boundary.value;
  boundary.value = "periodic";
  return `The border was ${before}; for a film law it is now periodic.`;
}

export function reset(name) {
  form.elements[name].value = defaults[name];
}

// A surface that repeats is solved as such, others are not, and a ball has a domain of its own; the user may still change
// it. Returns what to say of it.
export function surfaceKindChanged() {
  const { surface, boundary, load, side, side_unit: unit } = form.elements;
  const before = boundary.value;
  boundary.value = ["self-affine", "wavy"].includes(surface.value) || load.value === "film" ? "periodic" : "free";
  const said = before === boundary.value ? [] : [`The border was ${before}; for this surface it is now ${boundary.value}.`];
  const [former, own] = surface.value === "sphere" ? [defaults, first] : [first, defaults];
  if (side.value === former.side && unit.value === former.side_unit) {
    [side.value, unit.value] = [own.side, own.side_unit];
    if (!isMeasured(surface.value)) said.push(`The side of the domain is now ${own.side} ${UNITS.length[own.side_unit]}.`);
  }
  return said.join(" ");
}

const isMeasured = (kind) => ["file", "example"].includes(kind);

// Says under a field what is wrong with it, and opens its group; without an error nothing is wrong.
export function markWrong({ setting = "", message = "" } = {}) {
  form.querySelector(".wrong")?.remove();
  for (const name of ["aria-invalid", "aria-errormessage"]) form.querySelector(`[${name}]`)?.removeAttribute(name);
  const control = form.elements[setting];
  if (!control || control.closest("[hidden]")) return;
  control.setAttribute("aria-invalid", "true");
  control.setAttribute("aria-errormessage", "wrong");
  control.closest("details").open = true;
  (control.closest(".field") || control.parentElement).append(element("p", message, { class: "wrong", id: "wrong", role: "alert" }));
}

const needsOf = (facts) => facts && {
  size: facts.size === null, metric: !facts.metric, rows: facts.needs_rows, non_measured: facts.non_measured > 0,
};

// The facts that each file states, by the prefix of its map.
export function showFields(facts) {
  for (const part of form.querySelectorAll("[data-when]")) {
    const [name, values] = part.dataset.when.split("=");
    // A registered name may have blanks.
    const wanted = ` ${values} `.includes(` ${textOf(form.elements[name])} `);
    part.hidden = !wanted || (part.dataset.need !== undefined && !needsOf(facts[part.dataset.map])?.[part.dataset.need]);
  }
  showPresets(read());
  for (const [prefix, known] of Object.entries(facts)) {
    if (needsOf(known)?.size) document.getElementById(`${prefix}size-help`).textContent = whichIsX(prefix, known);
  }
}

function whichIsX(prefix, { shape: [first, second], needs_rows: open }) {
  const isText = /\.(csv|tsv|txt|dat|asc)$/i.test(hidden[`${prefix}file_name`]);
  const rows = isText ? `${first} lines of the file` : `${first} points, along the first index`;
  const columns = isText ? `${second} values in each` : `${second} points, along the second`;
  return open && form.elements[`${prefix}rows`].value === "y" ? `x: ${columns}; y: ${rows}.` : `x: ${rows}; y: ${columns}.`;
}

// Only what differs from the defaults, so that links stay short; the surface always, so that none is empty.
export function toFragment(run) {
  const isSaid = ([name, value]) => name === "surface" || (name !== "scheme" && value !== defaults[name]);
  const changed = Object.entries(read()).filter(isSaid);
  const query = new URLSearchParams(changed);
  if (run) query.set("run", run);
  return query.toString();
}

// Settings and run of a link, or the problem with it, in a sentence.
export function fromFragment(text) {
  const { run = "", ...values } = Object.fromEntries(new URLSearchParams(text.trim().replace(/^[^#]*#/, "")));
  const unknown = Object.keys(values).find((name) => !(name in defaults));
  if (unknown !== undefined) return { problem: `This is no link to settings of this page: it has no setting '${unknown}'.` };
  const wrong = Object.keys(values).find((name) => !isChoice(name, values));
  if (wrong) return { problem: `The link is not used: its '${wrong}' is '${values[wrong]}', which the page does not offer.` };
  return { run, values, problem: "" };
}

function isChoice(name, values) {
  const control = form.elements[name];
  if (name === "load_unit") return values[name] in UNITS[values.load || defaults.load];
  if (control?.type === "checkbox") return ["yes", "no"].includes(values[name]);
  return control?.tagName !== "SELECT" || [...control.options].some((option) => option.value === values[name]);
}

// Whether the form asks for something else than a run had; what is hidden does not count.
export function differ(others) {
  const own = read();
  const kinds = { file: "surface", [`${OTHER}file`]: `${OTHER}surface` };
  const counts = (name) => (name in kinds ? isFile(kinds[name]) : form.elements[name] && !form.elements[name].closest("[hidden]"));
  return Object.keys(defaults).some((name) => counts(name) && own[name].trim() !== others[name]);
}

