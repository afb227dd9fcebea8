/** Numbers in sentences as Python writes them, so that page and server refuse in the same words. */

export function degrees(angle: number): number {
  return angle * (180 / Math.PI);
}

/** Return `f"{value:.{digits}f}"` of Python, which rounds exact halves to even. */
export function fixed(value: number, digits: number): string {
  if (!Number.isFinite(value)) return unbounded(value);
  const text = halfToEven(Math.abs(value), digits);
  return value < 0 || Object.is(value, -0) ? `-${text}` : text;
}

function halfToEven(size: number, digits: number): string {
  if (size >= 1e21) return `${BigInt(size)}${digits ? `.${"0".repeat(digits)}` : ""}`; // there `toFixed` gives exponents
  const longer = size.toFixed(digits + 1),
    cut = longer.slice(0, digits ? -1 : -2);
  const half = longer.endsWith("5") && (size * 2 ** (digits + 1)) % 1 === 0; // then it has no more decimals
  return half && Number(cut.at(-1)) % 2 === 0 ? cut : size.toFixed(digits);
}

/** Return `f"{value:.{digits}g}"` of Python. */
export function general(value: number, digits = 6): string {
  if (!Number.isFinite(value)) return unbounded(value);
  if (Object.is(value, -0)) return "-0";
  const [mantissa = "", power = "0"] = value.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  if (exponent >= -4 && exponent < digits) return withoutZeros(value.toFixed(digits - 1 - exponent));
  return `${withoutZeros(mantissa)}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
}

function withoutZeros(text: string): string {
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

function unbounded(value: number): string {
  return Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";
}
