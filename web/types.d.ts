// Types of what crosses between the core and the page, for `tsc` alone: the page is not compiled.
/// <reference types="uplot" />

type Numbers = Float64Array | number[];

interface Hint {
  option: string | null;
  value: any;
  advice: string;
}

interface PreviewTable {
  name: string;
  rows: number;
  columns: { number: number; header: string }[];
}

interface Preview {
  format: string;
  tables: PreviewTable[];
  analysis: string;
  models: string[];
}

interface ParameterRow {
  words: string;
  symbol: string;
  value: string;
  uncertainty: string;
  unit: string;
  interval: string;
  relative: string;
  absent: boolean;
}

interface TableOfAnswer {
  title: string;
  headings: string[];
  rows: string[][];
  chosen: number | null;
  note: string | null;
}

interface Trace {
  time_s: Numbers;
  signal: Numbers;
  fitted: (number | null)[];
  unit: string;
  used_s: [number, number];
}

interface Answered {
  analysis: string;
  json: string;
  document: {
    subject: string;
    sentence: string;
    parameters: ParameterRow[];
    tables: TableOfAnswer[];
    facts: [string, string][];
    panels: string[];
  };
  warnings: { code: string; message: string; hints: Hint[] }[];
  trace: Trace | null;
  command: string;
  python: string;
}

interface Bytes {
  name: string;
  bytes: Uint8Array<ArrayBuffer>;
}

/** A file in the page, with what was made of it. */
interface Loaded extends Bytes {
  options: Record<string, any>;
  reference: Bytes | null;
  seen: Preview | null;
  /** What the answer was asked. */
  asked: string;
  answer: Answered | null;
  /** The answer of the contract, docs/json.md. */
  json: any;
  error: { message: string; hints: Hint[] } | null;
  formOpen: boolean;
  took: number;
}

interface Plot {
  drawn: uPlot;
  all: () => void;
  remove: () => void;
}

/** Sets an option of the current file; null leaves it to the file. */
type Apply = (option: string, value: any, quietly?: boolean) => void;

interface Window {
  slipfit: { readonly current: Loaded | null; take: (name: string, bytes: Uint8Array<ArrayBuffer>) => Promise<void>; output: (what: string) => Promise<string> };
}

interface DeviceMotionEventConstructor {
  requestPermission?: () => Promise<string>;
}
