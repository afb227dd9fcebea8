"""What of a robot's stage can be seen, at the sizes that its page is made for."""

from tests.e2e.drawn import size

SIZES = [(1440, 900), (1280, 720), (390, 844), (360, 640), (844, 390), (640, 360)]

# what stays in view, and what is in the way: out of the window, or covered in the middle or near the middle of an edge, as
# seen from where lines begin
SEEN = """
  const CROSS = [[0.5, 0.5], [0.1, 0.5], [0.9, 0.5], [0.3, 0.15], [0.5, 0.85]];
  const shown = (e) => e.checkVisibility({ visibilityProperty: true }) && e.getBoundingClientRect().width > 0;
  const covered = (e, [u, v]) => {
    const { x, y, width, height } = e.getBoundingClientRect(),
      across = getComputedStyle(document.body).direction === "rtl" ? 1 - u : u,
      at = document.elementFromPoint(x + across * width, y + v * height);
    return at && (e.contains(at) || at.contains(e) || at.closest("label")?.contains(e)) ? "" : `below ${at ? at.outerHTML.slice(0, 90) : "an edge"}`;
  };
  const place = (e) => Object.values(e.getBoundingClientRect().toJSON()).slice(0, 4).map(Math.round).join(" ");
  const out = (e) => {
    const { top, left, bottom, right } = e.getBoundingClientRect();
    return top < -1 || left < -1 || bottom > innerHeight + 1 || right > innerWidth + 1 ? "out of the window" : "";
  };
  const unseen = (selectors) => selectors.flatMap((selector) => {
    const e = [...document.querySelectorAll(selector)].find(shown);
    const why = e ? out(e) || CROSS.map((at) => covered(e, at)).find((one) => one) : "not shown";
    return why ? [`${selector} is ${why}, at ${e ? place(e) : ""}`] : [];
  });
"""
# bring each control into use, one after the other; what stays in view is looked at each time
EACH = f"""([selectors, from]) => {{
  {SEEN}
  for (const more of document.querySelectorAll("#stage details")) more.open = true;
  const controls = [...document.querySelectorAll("#stage :is(button, a[href], input, select, textarea, summary, [tabindex='0'])")]
    .filter((e) => shown(e) && !e.closest(".blocks, dialog, .visually-hidden"));
  const found = [];
  for (const control of from === "below" ? controls.reverse() : controls) {{
    control.focus();
    const name = control.outerHTML.slice(0, 90);
    found.push(...unseen(selectors).map((why) => `${{why}}; in use: ${{name}}`));
    const why = control.getBoundingClientRect().height < innerHeight / 4 && covered(control, [0.5, 0.5]);
    if (document.activeElement === control && why) found.push(`${{name}}, at ${{place(control)}}, is ${{why}}`);
  }}
  return [controls.length, [...new Set(found)].slice(0, 6)];
}}"""


def assert_in_view(page, selectors, sizes=SIZES, modes=("",)):
    """See that, whatever control has the focus, at each of these sizes what stays is in view, and the control too."""
    for wide, high in sizes:
        size(page, wide, high)
        for mode in modes:
            if mode:
                page.evaluate("(mode) => document.getElementById('tab-' + mode).click()", mode)
            for begin in ("above", "below"):
                count, found = page.evaluate(EACH, [selectors, begin])
                assert count >= 3, "controls are shown"
                assert found == [], (wide, high, mode, begin, found)
