// Sliders beside a decay and a resonance curve: the exact motion and the paper's approximations.
import { el, text } from "./dom.js";
import { Cancelled, Refused, ask } from "./engine.js";
import { plot } from "./plot.js";

/** Cycles shown of a decay, and samples in each. */
const MOST_CYCLES = 400;
const SAMPLES = 24;

/**
 * Fills the section; `analyse` takes the simulated decay.
 * @param {HTMLElement} host
 * @param {(name: string, bytes: Uint8Array<ArrayBuffer>) => Promise<void>} analyse
 */
export function setUp(host, analyse) {
  const chosen = { q: 30, beta: 0.5, noise: 0.005 };
  const error = el("p", { role: "alert", class: "error" });
  const decayHost = el("div", {});
  const curveHost = el("div", {});
  /** @type {Plot[]} */
  let shown = [];
  let csv = "";
  let busy = false;
  let again = false;

  /**
   * @param {string} name
   * @param {{min: number, max: number, step: number, value: number, show: (v: number) => string, set: (v: number) => void}} range
   */
  const slider = (name, { min, max, step, value, show, set }) => {
    const output = el("output", { for: `slider-${name}` }, show(value));
    const input = el("input", { id: `slider-${name}`, type: "range", min, max, step, value });
    input.addEventListener("input", () => {
      set(Number(input.value));
      output.textContent = show(Number(input.value));
      input.setAttribute("aria-valuetext", output.textContent);
      draw();
    });
    return el("div", { class: "field" }, el("label", { for: input.id }, text(`simulate.${name}`)), input, output);
  };

  const draw = async () => {
    if (busy) {
      again = true;
      return;
    }
    busy = true;
    try {
      // The drive of the curve is one; the decay begins where the curve without friction peaks.
      const amplitude = chosen.q;
      const cycles = Math.min(MOST_CYCLES, Math.max(6, Math.ceil(1.6 * chosen.q)));
      const curve = await ask("simulateResonance", JSON.stringify({ q_factor: chosen.q, friction_ratio: chosen.beta, points: 241 }));
      const decay = await ask(
        "simulateDecay",
        JSON.stringify({
          frequency_hz: 1,
          q_factor: chosen.q,
          friction_ratio: chosen.beta,
          amplitude,
          duration_s: cycles,
          rate_hz: SAMPLES,
          noise_rms: chosen.noise * amplitude,
          seed: 1,
        }),
      );
      error.textContent = "";
      csv = decay.csv;
      shown.forEach((drawn) => drawn.remove());
      shown = [drawDecay(decayHost, decay), drawCurve(curveHost, curve)];
    } catch (problem) {
      if (problem instanceof Refused) error.textContent = problem.message;
      else if (!(problem instanceof Cancelled)) throw problem;
    } finally {
      busy = false;
      if (again) {
        again = false;
        draw();
      }
    }
  };

  const sliders = el(
    "div",
    { class: "sliders" },
    slider("q", { min: 0.5, max: 2.5, step: 0.01, value: Math.log10(chosen.q), show: (v) => (10 ** v).toPrecision(3), set: (v) => (chosen.q = 10 ** v) }),
    slider("friction", { min: 0, max: 1.2, step: 0.01, value: chosen.beta, show: (v) => v.toFixed(2), set: (v) => (chosen.beta = v) }),
    slider("noise", { min: 0, max: 0.05, step: 0.001, value: chosen.noise, show: (v) => `${(100 * v).toFixed(1)} %`, set: (v) => (chosen.noise = v) }),
  );
  const send = () => analyse("simulated.csv", new TextEncoder().encode(csv));
  host.append(
    el("h2", {}, text("simulate.title")),
    el("p", {}, text("simulate.help")),
    sliders,
    error,
    el("h3", {}, text("simulate.decay")),
    decayHost,
    el("button", { type: "button", id: "simulate-analyse", onclick: send }, text("simulate.analyse")),
    el("h3", {}, text("simulate.resonance")),
    curveHost,
    el("p", { class: "soft" }, text("simulate.scale")),
  );
  draw();
}

/**
 * @param {HTMLElement} host
 * @param {{time_s: number[], displacement: number[], paper: (number | null)[]}} decay
 */
function drawDecay(host, decay) {
  return plot(host, {
    description: text("simulate.decay"),
    x: text("simulate.time"),
    y: text("simulate.amplitude"),
    along: decay.time_s,
    series: [
      { label: text("simulate.displacement"), values: decay.displacement, color: "data" },
      { label: text("simulate.paper"), values: decay.paper, color: "fit", width: 2 },
    ],
  });
}

/** @param {HTMLElement} host @param {Record<string, number[]>} curve */
function drawCurve(host, curve) {
  return plot(host, {
    description: text("simulate.resonance"),
    x: text("simulate.frequency"),
    y: text("simulate.amplitude"),
    along: curve.frequency,
    series: [
      { label: text("simulate.exact"), values: curve.exact, color: "ink", width: 2 },
      { label: text("simulate.leading"), values: curve.leading, color: "fit", dash: [8, 4] },
      { label: text("simulate.lorentzian"), values: curve.lorentzian, color: "third", dash: [3, 3] },
      { label: text("simulate.without"), values: curve.without_friction, color: "fourth", width: 1 },
    ],
  });
}
