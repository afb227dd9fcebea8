"""Waiting until a page has drawn what it had to."""

# the page has done what it had to do, and drawn it
IDLE = "() => new Promise((done) => requestIdleCallback(() => requestAnimationFrame(() => setTimeout(done))))"
# observers of sizes and of what is in view run once a frame, and what they change is drawn in the next
FRAMES = """() => new Promise((done) => {
  const frame = (left) => left ? requestAnimationFrame(() => frame(left - 1)) : setTimeout(done);
  frame(3);
})"""


def settle(page):
    """Wait until observers have answered a change of the page's size or place, however slowly it draws."""
    page.wait_for_timeout(100)  # smooth scrolling and transitions begin
    page.evaluate(FRAMES)
