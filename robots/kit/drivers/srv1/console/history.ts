/** The last minutes of a reading: which samples are stored, how they are drawn, and how they are said. */
import { gettext, ngettext } from "/static/farhand/v1/text.js";

export interface Sample {
  at: number;
  value: number;
}

export const KEPT_MS = 300_000,
  STEP_MS = 2000;
const WIDE = 100,
  HIGH = 20; // of the picture

/** Return the samples with a new one, at most one in two seconds of the last five minutes. Time may jump back. */
export function added(samples: readonly Sample[], at: number, value: number | undefined): readonly Sample[] {
  if (value === undefined || !Number.isFinite(value) || !Number.isFinite(at)) return samples;
  const last = samples.at(-1);
  if (last && at < last.at) return [{ at, value }]; // a recording was set back
  if (last && at - last.at < STEP_MS) return samples;
  return [...samples.filter((one) => at - one.at <= KEPT_MS), { at, value }];
}

/** Return the least and the greatest value; null without samples. */
function extent(samples: readonly Sample[]): readonly [number, number] | null {
  return samples.length ? [Math.min(...samples.map((s) => s.value)), Math.max(...samples.map((s) => s.value))] : null;
}

/** Return the line in a picture of 100 by 20, with the present at its right. `least`: the smallest range that fills its height. */
export function line(samples: readonly Sample[], now: number, least: number): string {
  const range = extent(samples);
  if (!range) return "";
  const [low, high] = range,
    middle = (low + high) / 2,
    span = Math.max(high - low, least, 1e-9);
  const point = ({ at, value }: Sample): string => {
    const x = WIDE * (1 - Math.max(0, now - at) / KEPT_MS),
      y = HIGH / 2 - ((value - middle) / span) * (HIGH - 4);
    return `${x.toFixed(1)},${y.toFixed(1)}`;
  };
  const recent = samples.filter(({ at }) => now - at <= KEPT_MS);
  return recent.map(point).join(" ");
}

/** Return the history in words, for people who do not see the line. */
export function inWords(name: string, samples: readonly Sample[], words: (value: number) => string): string {
  const range = extent(samples),
    first = samples[0],
    last = samples.at(-1);
  if (!range || !first || !last) return gettext("{name}: not known yet", { name });
  const minutes = Math.max(1, Math.round((last.at - first.at) / 60_000));
  const [low = "", high = ""] = range.map(words);
  const same = { name, value: low },
    values = { name, low, high, now: words(last.value) };
  return low === high
    ? ngettext("{name}: {value} in the last minute", "{name}: {value} in the last {count} minutes", minutes, same)
    : ngettext(
        "{name}: from {low} to {high} in the last minute, now {now}",
        "{name}: from {low} to {high} in the last {count} minutes, now {now}",
        minutes,
        values,
      );
}
