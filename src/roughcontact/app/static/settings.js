// The form, its dependent fields, and the link that holds it.

export const form = document.getElementById("settings");
const UNITS = {
  length: { m: "m", mm: "mm", um: "µm", nm: "nm" },
  modulus: { Pa: "Pa", MPa: "MPa", GPa: "GPa" },
  pressure: { Pa: "Pa", kPa: "kPa", MPa: "MPa", GPa: "GPa" },
  force: { N: "N", mN: "mN", uN: "µN", kN: "kN" },
  approach: { mm: "mm", um: "µm", nm: "nm" },
};
// At first for each kind of load: a value and its unit.
const FIRST_LOADS = { pressure: ["100", "MPa"], force: ["1", "N"], approach: ["0.1", "um"] };
// Young's modulus in GPa and Poisson's ratio, rounded: a first guess, not a certificate.
const MATERIALS = {
  steel: ["210", "0.3"],
  "stainless steel": ["195", "0.3"],
  "cast iron": ["120", "0.26"],
  "aluminium alloy": ["70", "0.33"],
  "copper": ["120", "0.34"],
  "brass": ["100", "0.35"],
  "titanium alloy": ["114", "0.34"],
  "silicon nitride": ["310", "0.27"],
  "alumina": ["370", "0.22"],
  "glass": ["70", "0.22"],
  "PTFE": ["0.5", "0.46"],
  "PEEK": ["3.8", "0.4"],
  "rubber": ["0.004", "0.495"],
};
let defaults = {};

export const darkness = matchMedia("(prefers-color-scheme: dark)");

function fill(select, options) {
  select.replaceChildren(...Object.entries(options).map(([value, text]) => new Option(text, value)));
}

// The page's own first values are those of the server, so that the link can omit them.
export function prepare(first, examples) {
  fill(form.elements.example, Object.fromEntries(examples.map((name) => [name, name.replaceAll("_", " ")])));
  for (const select of form.querySelectorAll("[data-units]")) fill(select, UNITS[select.dataset.units]);
  for (const select of form.querySelectorAll("[data-preset]")) {
    fill(select, { "": "choose", ...Object.fromEntries(Object.keys(MATERIALS).map((name) => [name, name])) });
    select.addEventListener("change", () => choosePreset(select));
  }
  defaults = first;
  write({});
}

function choosePreset(select) {
  const values = MATERIALS[select.value];
  if (!values) return;
  const prefix = select.dataset.preset;
  form.elements[`${prefix}young`].value = values[0];
  form.elements[`${prefix}young_unit`].value = "GPa";
  form.elements[`${prefix}poisson`].value = values[1];
}

const hidden = { file: "", file_name: "" };

export function read() {
  const found = { ...hidden, scheme: darkness.matches ? "dark" : "light" };
  for (const name of Object.keys(defaults)) {
    const element = form.elements[name];
    if (element) found[name] = element.value;
  }
  return found;
}

export function write(values) {
  const all = { ...defaults, ...values };
  fill(form.elements.load_unit, UNITS[all.load] || UNITS.pressure);
  for (const [name, value] of Object.entries(all)) {
    if (name in hidden) hidden[name] = value;
    else if (form.elements[name]) form.elements[name].value = value;
  }
}

export function setFile(digest, name) {
  Object.assign(hidden, { file: digest, file_name: name });
}

export function loadKindChanged() {
  const kind = form.elements.load.value;
  fill(form.elements.load_unit, UNITS[kind]);
  [form.elements.loads.value, form.elements.load_unit.value] = FIRST_LOADS[kind];
}

// A surface that repeats is solved as such, others are not; the user may still change it.
export function surfaceKindChanged() {
  const periodic = ["self-affine", "wavy"].includes(form.elements.surface.value);
  form.elements.boundary.value = periodic ? "periodic" : "free";
}

export function showFields(facts) {
  const needs = {
    size: facts && facts.size === null,
    metric: facts && !facts.metric,
    non_measured: facts && facts.non_measured > 0,
  };
  for (const part of form.querySelectorAll("[data-when]")) {
    const [name, values] = part.dataset.when.split("=");
    const wanted = values.split(" ").includes(form.elements[name].value);
    part.hidden = !wanted || (part.dataset.need !== undefined && !needs[part.dataset.need]);
  }
}

// Only what differs from the first values, so that links stay short.
export function toFragment(run) {
  const changed = Object.entries(read()).filter(([name, value]) => name !== "scheme" && value !== defaults[name]);
  const query = new URLSearchParams(changed);
  if (run) query.set("run", run);
  return query.toString();
}

export function fromFragment(text) {
  const query = Object.fromEntries(new URLSearchParams(text.replace(/^[^#]*#/, "").replace(/^#/, "")));
  const run = query.run || "";
  const values = Object.fromEntries(Object.entries(query).filter(([name]) => name in defaults));
  return { run, values };
}
