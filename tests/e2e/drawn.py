"""Waiting until a page has drawn what it had to."""

from playwright.sync_api import expect

# the page has done what it had to do, and drawn it
IDLE = "() => new Promise((done) => requestIdleCallback(() => requestAnimationFrame(() => setTimeout(done))))"
# observers of sizes and of what is in view run once a frame, and what they change is drawn in the next; smooth
# scrolling begins some frames later and is over when nothing has moved for as many
STEADY = """(frames) => new Promise((done) => {
  let was = "", same = 0;
  const frame = () => {
    const is = `${scrollX} ${scrollY} ${innerWidth} ${innerHeight} ${document.documentElement.scrollHeight}`;
    [same, was] = [is === was ? same + 1 : 0, is];
    if (same < frames) requestAnimationFrame(frame);
    else setTimeout(done);
  };
  frame();
})"""
# a line that comes and goes above the panels, as when a robot is silent for a moment, moves the panels below it
QUIET = "() => { document.getElementById('banner').style.display = 'none'; }"


def settle(page):
    """Wait until observers have answered a change of the page's size or place, however slowly it draws."""
    page.evaluate(STEADY, 8)


def size(page, wide, high):
    """Make the page so large, and wait until observers have answered; nothing scrolls smoothly by that."""
    page.set_viewport_size({"width": wide, "height": high})
    page.evaluate(STEADY, 3)


def scroll(page, share):
    """Stand at a share of the page's height, at once, and wait until observers have answered."""
    page.evaluate(
        "(share) => scrollTo({top: share * document.documentElement.scrollHeight, behavior: 'instant'})", share
    )
    page.evaluate(STEADY, 3)


def blocks(page, box="#blocks"):
    """Wait for the blocks of programs; over a line that a busy machine makes slow they come when they are asked for."""
    load = page.locator(box).get_by_role("button", name="Load the blocks")
    workspace = page.locator(f"{box} .blocklySvg")
    expect(load.or_(workspace)).to_be_visible()
    if load.is_visible():
        load.click()
    expect(workspace).to_be_visible()
