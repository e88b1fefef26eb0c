// What settings mean, in words: the one line of each group of the form, and that of a run.

import { materials, nameMaterial, OTHER } from "./fields.js";

const form = document.getElementById("settings");
const FORMS = { plane: "its plane", quadratic: "its form of second degree", sphere: "its sphere" };
const ADDED = { ball: "a ball", "cylinder-y": "a cylinder along y", "cylinder-x": "a cylinder along x" };
const BORDERS = {
  free: "free", periodic: "repeating", "free-periodic": "repeating along y", "periodic-free": "repeating along x", wrapped: "wrapped",
};
// Surfaces that come with their own points, and the others, which the page makes on a square.
const isMeasured = ({ surface }) => ["file", "example"].includes(surface);

// A setting with its unit.
const unitsOf = (values) => (name, unit = `${name}_unit`) => {
  const shown = values[unit].replace(/^u/, "µ").replace("m2", "m²");
  return values[name].trim() ? `${values[name].trim()} ${shown}` : `? ${shown}`;
};

export const isPath = ({ load, path }) => path === "yes" && ["pressure", "force", "approach"].includes(load);

function describePath(values, of) {
  // A list that ends with a unit needs none.
  const listed = (name) => (/[a-z]$/i.test(values[name]) ? values[name] : of(name));
  const passing = ["time", "sliding"].filter((name) => values[name]).map((name) => `${name} ${listed(name)}`);
  return ["a path", ...passing, ...ticked(values, "law_")].join(", ");
}

// What is ticked, in words, of the boxes whose names begin alike.
const ticked = (values, prefix) => [...form.querySelectorAll(`[type=checkbox][name^=${prefix}]`)]
  .filter(({ name }) => values[name] === "yes").map(({ name }) => name.replace(prefix, "").replaceAll("_", " "));

export const subjectOf = ({ surface, file_name: name, example }) => ({ file: name || "map", example: example.replaceAll("_", " ") }[surface] || surface);

// What is taken away from a map of these settings.
function listTreatment(values, of, prefix = "") {
  const form = FORMS[values[`${prefix}form`]];
  return [...(values[`${prefix}tip_radius`] ? [`restored from a tip of ${of(`${prefix}tip_radius`)}`] : []), ...(form ? [`less ${form}`] : [])];
}

function describeOther(values, of) {
  const parts = [`on ${values.counterbody_file_name || "map"}`, ...listTreatment(values, of, OTHER)];
  if (Number(values.offset_x) || Number(values.offset_y)) parts.push(`shifted by ${values.offset_x}, ${of("offset_y", "offset_unit")}`);
  if (Number(values.rotation)) parts.push(`rotated by ${values.rotation}°`);
  if (values.mirrored === "yes") parts.push("mirrored");
  return parts.join(" ");
}

// What is given of the fields of a part, in words.
function describeFields(fields, values, of, prefix) {
  return fields.flatMap(({ field, parts }) => {
    const text = values[`${prefix}${field.setting}`];
    const part = parts.find((one) => one.name === text);
    if (parts.length) return part ? [`${part.label.toLowerCase()} (${describeFields(part.fields, values, of, prefix).join("; ")})`] : [];
    return text ? [`${field.name.replaceAll("_", " ")} ${field.kind ? of(`${prefix}${field.setting}`) : text}`] : [];
  });
}

function describeMaterial(values, of, prefix) {
  const hard = values[`${prefix}hardness`] ? `hardness ${of(`${prefix}hardness`)}` : "elastic";
  if (values[`${prefix}material`] === "viscoelastic") return `moduli ${of(`${prefix}moduli`)} relaxing in ${of(`${prefix}relaxation`)}`;
  const other = materials.find(({ name }) => name === values[`${prefix}material`]);
  if (other) {
    const shared = { young: () => `E ${of(`${prefix}young`)}`, poisson: () => `ν ${values[`${prefix}poisson`]}` };
    return [other.label, ...other.shared.map((name) => shared[name]()), ...describeFields(other.fields, values, of, prefix)].join(", ");
  }
  return `E ${of(`${prefix}young`)}, ν ${values[`${prefix}poisson`]}, ${hard}`;
}

function summarizeMaterial(values, of, prefix) {
  const name = nameMaterial(values, prefix);
  if (values[`${prefix}material`] === "elastic") return [name, of(`${prefix}young`), `ν\u00a0${values[`${prefix}poisson`]}`].filter(Boolean).join(", ");
  return name || describeMaterial(values, of, prefix);
}

function summarizeMaterials(values, of) {
  const own = summarizeMaterial(values, of, "");
  if (values.counterbody === "rigid") return `${own}; counterbody rigid`;
  const other = summarizeMaterial(values, of, OTHER);
  return own === other ? `both ${own}` : `${own}; counterbody ${other}`;
}

function summarizeSurface(values, of) {
  const less = isMeasured(values) ? listTreatment(values, of).map((text) => `, ${text}`).join("") : "";
  return {
    sphere: () => `ball, radius ${of("radius")}`,
    example: () => `example: ${subjectOf(values)}${less}`,
    file: () => `map ${values.file_name || "in a file: none chosen yet"}${less}`,
    "self-affine": () => `self-affine, Sq ${of("rms_height")}, H ${values.hurst}`,
    wavy: () => `wavy, amplitude ${of("amplitude")}, wavelength ${of("wavelength")}`,
  }[values.surface]();
}

function summarizeOther(values, of) {
  const parts = isMeasured(values) && values.counterbody_surface === "file" ? [describeOther(values, of).replace(/^on /, "map ")] : [];
  if (values.ball && values.surface !== "sphere") parts.push(`${ADDED[values.added]}, radius ${of("ball")}`);
  return parts.join("; ") || "a plane";
}

function describeLayers(values, of, prefix) {
  const layer = (number) => `${of(`${prefix}layer${number}_thickness`)} of ${of(`${prefix}layer${number}_young`)}`;
  return Array.from({ length: Number(values[`${prefix}layers`]) }, (_, index) => layer(index + 1)).join(" on ");
}

function summarizeContact(values, of) {
  const coated = ["", OTHER].filter((prefix) => values[`${prefix}layers`] !== "0");
  const parts = {
    adhesion: values.adhesion !== "none" && `${values.adhesion.replaceAll("-", " ")} adhesion, ${of("work")}`,
    friction: values.load === "fretting" && `friction ${values.friction}`,
    layers: coated.map((prefix) => `${prefix ? "counterbody" : "body"} coated: ${describeLayers(values, of, prefix)}`).join("; "),
  };
  const given = Object.values(parts).filter(Boolean);
  const missing = Object.keys(parts).filter((name) => !parts[name]).join(", ").replace(/, ([a-z]+)$/, " or $1");
  return [...given, ...(missing ? [`no ${missing}`] : [])].join("; ");
}

function summarizeLoad(values, of) {
  const { load } = values;
  if (load === "cycle") return `approach ${values.cycle_from} to ${of("cycle_to", "cycle_unit")} and back`;
  if (load === "film") return `film law over separations ${values.separations} Sq`;
  if (load === "fretting") return `${of("normal_force")}, pushed by ±${of("tangential_force")}`;
  const several = values.loads.trim().split(/[\s;]+/).length > 1;
  const name = { pressure: "mean pressure", force: "force", approach: "approach" }[load];
  return `${name} ${of("loads", "load_unit")}${isPath(values) ? `: ${describePath(values, of)}` : several ? ": a curve" : ""}`;
}

function summarizeGrid(values, of) {
  const cells = isMeasured(values) ? "the points of the map" : `${values.cells} × ${values.cells} cells, ${of("side")}`;
  return `${cells}, ${BORDERS[values.boundary]}`;
}

// The one line of each group, by its name.
export function summarize(values) {
  const of = unitsOf(values);
  return {
    surface: summarizeSurface(values, of),
    counterbody: summarizeOther(values, of),
    materials: summarizeMaterials(values, of),
    contact: summarizeContact(values, of),
    load: summarizeLoad(values, of),
    questions: ["area, pressure, approach", ...ticked(values, "ask_")].join(", "),
    grid: summarizeGrid(values, of),
  };
}

// What a run has solved, in a line.
export function describe(values) {
  const of = unitsOf(values);
  const material = (prefix) => describeMaterial(values, of, prefix);
  const parts = [values.surface === "sphere" ? `ball of ${of("radius")}` : subjectOf(values)];
  if (isMeasured(values)) parts.push(...listTreatment(values, of));
  if (values.ball && values.surface !== "sphere") parts.push(`${values.added.replace("-", " along ")} of ${of("ball")}`);
  const load = {
    approach: `approach ${of("loads", "load_unit")}`,
    cycle: `approach from ${values.cycle_from} to ${of("cycle_to", "cycle_unit")} and back`,
    film: `film law over ${values.separations} Sq`,
    fretting: `normal force ${of("normal_force")}, tangential force ±${of("tangential_force")}, friction ${values.friction}`,
  };
  if (isMeasured(values) && values.counterbody_surface === "file") parts.push(describeOther(values, of));
  parts.push(load[values.load] || of("loads", "load_unit"), ...(isPath(values) ? [describePath(values, of)] : []), material(""));
  if (values.counterbody === "deformable") parts.push(`counterbody ${material("counterbody_")}`);
  for (const [prefix, whose] of [["", "body"], ["counterbody_", "counterbody"]]) {
    for (let number = 1; number <= Number(values[`${prefix}layers`]); number += 1) {
      parts.push(`layer ${number} of the ${whose} ${of(`${prefix}layer${number}_thickness`)}, E ${of(`${prefix}layer${number}_young`)}`);
    }
  }
  if (values.adhesion !== "none") parts.push(`${values.adhesion.replaceAll("-", " ")} adhesion of ${of("work")}`);
  if (["exponential", "van-der-waals"].includes(values.adhesion)) parts.push(`range ${of("range")}`);
  const asked = ticked(values, "ask_");
  return [...parts, values.boundary].join(", ") + (asked.length ? `; with ${asked.join(", ")}` : "");
}
