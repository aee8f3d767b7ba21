// What was taken of a file, with controls to change it.
import { el, text } from "./dom.js";

/** The controls of each analysis: names of options and how they are typed. */
/** @type {Record<string, {reading: Record<string, string>, analysis: Record<string, string>}>} */
const FIELDS = {
  ringdown: {
    reading: { time: "column", signal: "column", quadrature: "column", unit: "text", kind: "kind", time_unit: "text", rate_hz: "number" },
    analysis: { start_s: "number", end_s: "number", band_hz: "pair", model: "model", law: "law", min_amplitude: "number", frequency_hz: "number", lockin_time_constant_s: "number", lockin_order: "number" },
  },
  resonance: {
    reading: {
      frequency: "column",
      amplitude: "column",
      phase: "column",
      drive: "column",
      frequency_unit: "text",
      unit: "text",
      kind: "kind",
    },
    analysis: { band_hz: "pair", model: "model", drive_amplitude: "uncertain", method: "method", reference: "file" },
  },
  levels: {
    reading: { drive: "column", amplitude: "column", real: "column", imaginary: "column", std_error: "column", drive_unit: "text", unit: "text" },
    analysis: { drive_gain: "uncertain", q_factor: "uncertain", frequency_hz: "number" },
  },
};
const CONSTANTS = ["stiffness", "mass", "torsion_stiffness", "inertia"];
const METHODS = ["exact", "leading", "paper"];

/** @typedef {[string, string][]} Choices values and their labels */
/** @typedef {(value: any) => void} Change */

const number = (/** @type {string} */ typed) => {
  const value = Number(typed.trim().replace(",", "."));
  return typed.trim() === "" ? null : Number.isFinite(value) ? value : NaN;
};

/** One labelled control. @param {string} name @param {HTMLElement} control @param {string} label */
function field(name, control, label = text(`options.${name}`)) {
  control.id ||= `option-${name}`;
  return el("div", { class: "field" }, el("label", { for: control.id }, label), control);
}

/** @param {string} name @param {Choices} options @param {string | null | undefined} chosen @param {Change} change */
function choice(name, options, chosen, change) {
  const list = options.map(([value, label]) => el("option", { value }, label));
  const select = el("select", { id: `option-${name}`, onchange: () => change(select.value || null) }, ...list);
  select.value = chosen ?? "";
  return select;
}

/** @param {string} id @param {any} value @param {(input: HTMLInputElement) => void} change @param {Record<string, any>} attributes */
function typed(id, value, change, attributes = {}) {
  const input = el("input", { id, type: "text", value: value ?? "", autocomplete: "off", ...attributes });
  input.addEventListener("change", () => change(input));
  return input;
}

/** A number; what is none is said, and not used. @param {HTMLInputElement} input @param {(value: number | null) => void} use */
function checked(input, use) {
  const value = number(input.value);
  const wrong = Number.isNaN(value);
  input.setAttribute("aria-invalid", String(wrong));
  input.setCustomValidity(wrong ? text("options.notNumber") : "");
  if (wrong) input.reportValidity();
  else use(value);
}

/**
 * @param {string} name
 * @param {(number | null)[] | undefined} given
 * @param {string[]} labels
 * @param {(pair: (number | null)[]) => number[] | null | undefined} complete what is used of two values; undefined to wait
 * @param {Change} change
 */
function two(name, given, labels, complete, change) {
  const id = `option-${name}`;
  const values = [given?.[0] ?? null, given?.[1] ?? null];
  const inputs = labels.map((label, i) =>
    typed(
      i ? `${id}-${i}` : id,
      values[i],
      (input) =>
        checked(input, (value) => {
          values[i] = value;
          const pair = complete(values);
          if (pair !== undefined) change(pair);
        }),
      { inputmode: "decimal", "aria-label": `${text(`options.${name}`)}, ${label}` },
    ),
  );
  return el(
    "div",
    { class: "field" },
    el("label", { for: id }, text(`options.${name}`)),
    el("div", { class: "pair" }, inputs[0], el("span", { "aria-hidden": "true" }, labels[1]), inputs[1]),
  );
}

/** Both ends, or neither; nothing is done with one of them. */
const bothOrNone = (/** @type {(number | null)[]} */ [a, b]) => (a === null && b === null ? null : a === null || b === null ? undefined : [a, b]);
/** The value, its standard error zero unless given. */
const valueAndError = (/** @type {(number | null)[]} */ [value, error]) => (value === null ? null : [value, error ?? 0]);

/** What the answer says was taken as `name`. @param {string} name @param {any} json @returns {string} */
function found(name, json) {
  const input = json?.input;
  if (!input) return "";
  const column = (/** @type {{number: number, header: string} | undefined} */ taken) => (taken ? `${taken.number} ${taken.header}`.trim() : "");
  switch (name) {
    case "time":
      return column(input.time?.column);
    case "signal":
    case "quadrature":
      return column(input[name]);
    case "unit":
      return input.unit;
    case "drive_unit":
      return input.drive_unit;
    case "kind":
      return text("options.kinds")[input.kind] ?? "";
    case "rate_hz":
      return input.time?.rate_hz ? String(input.time.rate_hz) : "";
    case "model":
      return json.model ?? "";
    case "start_s":
      return input.time_range_used_s ? String(Number(input.time_range_used_s[0].toPrecision(6))) : "";
    case "end_s":
      return input.time_range_used_s ? String(Number(input.time_range_used_s[1].toPrecision(6))) : "";
    default:
      return column(input.taken?.[name]);
  }
}

/**
 * The form. `file` is `{seen, options, json, reference}`; `change(name, value)` is called with an option to
 * set (null: leave it to the file), `reset()` to leave all of them.
 * @param {Loaded} file
 * @param {Apply} change
 * @param {() => void} reset
 * @param {(chosen: File | null) => void} setReference
 */
export function optionsForm(file, change, reset, setReference) {
  const { seen, options, json } = file;
  const analysis = json?.command ?? seen?.analysis ?? options.analysis ?? "ringdown";
  const sheet = options.sheet ?? json?.input?.sheet;
  const table = seen?.tables.find((t) => t.name === sheet) ?? seen?.tables[0];
  const columns = (table?.columns ?? []).map((c) => /** @type {[string, string]} */ ([String(c.number), `${c.number} ${c.header}`.trim()]));
  /** @param {string} name @returns {[string, string]} */
  const asFound = (name) => ["", text("options.asFound")(found(name, json))];
  /** @param {string} name @param {string} kind */
  const control = (name, kind) => {
    const set = (/** @type {any} */ value) => change(name, value);
    const held = options[name];
    switch (kind) {
      case "column":
        return field(name, choice(name, [asFound(name), ...columns], held, set));
      case "kind":
        return field(name, choice(name, [asFound(name), ...Object.entries(text("options.kinds"))], held, set));
      case "method":
        return field(name, choice(name, [["", METHODS[0]], ...METHODS.slice(1).map((m) => /** @type {[string, string]} */ ([m, m]))], held, set));
      case "law":
        return field(name, choice(name, [["", text("options.none")], ...Object.entries(text("options.laws"))], held, set));
      case "model": {
        /** @type {Choices} */
        const models = (json?.comparison ?? []).map((/** @type {{model: string}} */ c) => [c.model, c.model]);
        // Those that are compared where they are asked for only.
        const asked = analysis === "ringdown" ? (seen?.models ?? []) : [];
        models.push(...asked.filter((m) => !models.some(([known]) => known === m)).map((m) => /** @type {[string, string]} */ ([m, m])));
        if (held && !models.some(([m]) => m === held)) models.push([held, held]);
        return field(name, choice(name, [asFound(name), ...models], held, set));
      }
      case "pair":
        return two(name, held, [text("options.low"), text("options.high")], bothOrNone, set);
      case "uncertain":
        return two(name, held, [text("options.value"), text("options.error")], valueAndError, set);
      case "number": {
        const attributes = { inputmode: "decimal", placeholder: found(name, json) };
        return field(name, typed(`option-${name}`, held, (input) => checked(input, set), attributes));
      }
      case "file": {
        const input = el("input", { id: `option-${name}`, type: "file" });
        input.addEventListener("change", () => setReference(input.files?.[0] ?? null));
        return el("div", { class: "field" }, el("label", { for: input.id }, text(`options.${name}`)), input,
          file.reference ? el("span", { class: "soft" }, file.reference.name) : null);
      }
      default: {
        const attributes = { placeholder: found(name, json) };
        const use = (/** @type {HTMLInputElement} */ input) => set(input.value.trim() || null);
        return field(name, typed(`option-${name}`, held, use, attributes));
      }
    }
  };
  /** @param {string} name @param {...HTMLElement} controls */
  const group = (name, ...controls) =>
    el("fieldset", {}, el("legend", {}, text(`options.groups.${name}`)), el("div", { class: "fields" }, ...controls));
  const analyses = /** @type {Choices} */ (Object.entries(text("analyses")));
  const reading = [
    field("analysis", choice("analysis", [["", text("options.asFound")(text("analyses")[analysis])], ...analyses], options.analysis, (v) => change("analysis", v))),
  ];
  if ((seen?.tables.length ?? 0) > 1) {
    const sheets = (seen?.tables ?? []).map((t) => /** @type {[string, string]} */ ([t.name, t.name]));
    reading.push(field("sheet", choice("sheet", [["", text("options.asFound")(json?.input?.sheet)], ...sheets], options.sheet, (v) => change("sheet", v))));
  }
  for (const [name, count] of [["part", json?.input?.tables], ["run", json?.input?.runs]]) {
    if (!(count > 1)) continue;
    const all = Array.from({ length: count }, (_, i) => /** @type {[string, string]} */ ([String(i + 1), String(i + 1)]));
    const held = options[name] === undefined ? null : String(options[name]);
    reading.push(field(name, choice(name, [["", text("options.asFound")("")], ...all], held, (v) => change(name, v && Number(v)))));
  }
  const fields = FIELDS[analysis];
  for (const [name, kind] of Object.entries(fields.reading)) reading.push(control(name, kind));
  const constant = CONSTANTS.find((name) => options[name]) ?? "";
  const pick = choice("constant", [["", text("options.none")], ...CONSTANTS.map((c) => /** @type {[string, string]} */ ([c, text(`options.${c}`)]))], constant, (chosen) => {
    if (constant) change(constant, null, chosen !== null);
    forces.replaceChildren(field("constant", pick), ...(chosen ? [control(chosen, "uncertain")] : []));
  });
  const forces = el("div", { class: "fields" }, field("constant", pick), constant ? control(constant, "uncertain") : null);
  return el(
    "form",
    { class: "options", onsubmit: (/** @type {Event} */ event) => event.preventDefault() },
    el("p", { class: "soft" }, text("options.hint")),
    group("reading", ...reading),
    group("analysis", ...Object.entries(fields.analysis).map(([name, kind]) => control(name, kind))),
    el("fieldset", {}, el("legend", {}, text("options.groups.forces")), forces),
    el("button", { type: "button", onclick: reset }, text("options.reset")),
  );
}
