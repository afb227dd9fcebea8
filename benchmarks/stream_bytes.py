"""Bytes a viewer a minute of live pictures as JPEG and as video, at equal SSIM, with all headers.

Video is VP8, or VP9 where the robot has it. The reference of SSIM is the scene itself, without the noise of the
camera's sensor, which no viewer wants and no coding can save (`NOISE=1`: with it). The quantizer is the coarsest whose
mean SSIM is not below that of the JPEGs, which are as the portal sends them. Beside: the quantizer with which the
portal sends video.
"""

import os
import time

import cv2
import numpy as np

from benchmarks._scenes import Pair, Picture, Scene, scenes
from benchmarks.stage import set_up, tell

MINUTES = float(os.environ.get("MINUTES", "1"))
ROBOT = os.environ.get("ROBOT", "")  # only this one's cameras
GOAL = 5.0
FINEST, COARSEST = 2, 60


def ssim(a: Picture, b: Picture) -> float:
    """Return the mean structural similarity of two pictures' brightness (Wang, Bovik, Sheikh, Simoncelli 2004)."""
    x, y = (_luma(p).astype(np.float32) for p in (a, b))
    mx, my = _blurred(x), _blurred(y)
    vx, vy, both = _blurred(x * x) - mx * mx, _blurred(y * y) - my * my, _blurred(x * y) - mx * my
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    found = ((2 * mx * my + c1) * (2 * both + c2)) / ((mx * mx + my * my + c1) * (vx + vy + c2))
    return float(found[5:-5, 5:-5].mean())


def _blurred(values: Picture) -> Picture:
    return np.asarray(cv2.GaussianBlur(values, (11, 11), 1.5))


def _luma(picture: Picture) -> Picture:
    return picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY))


def framed(packet: bytes) -> int:
    """Return the bytes of a WebSocket message."""
    from portal.edge.direct import binary_frame

    return len(binary_frame(packet))


def as_jpeg(scene: Scene, pairs: list[Pair]) -> tuple[int, float]:
    """Return all bytes and the mean SSIM."""
    from robots.kit.packets import picture_packet, read_picture
    from workers.media.steps import QUALITY, jpeg

    size, likeness = 0, []
    for number, (clear, seen) in enumerate(pairs, 1):
        packet = picture_packet(number, 0, 1, (0.0,) * scene.joints, jpeg(seen, QUALITY))
        size += framed(packet)
        shown = cv2.imdecode(np.frombuffer(read_picture(packet), np.uint8), cv2.IMREAD_GRAYSCALE)
        likeness.append(ssim(clear, np.asarray(shown)))
    return size, float(np.mean(likeness))


def as_video(scene: Scene, pairs: list[Pair], quantizer: int) -> tuple[int, float, float]:
    """Return all bytes, the mean SSIM, and the processor's time for each picture (ms)."""
    import av

    from robots.kit.contract.video import unpack
    from workers.media.video import Shot, Video

    video, decoder = Video("bench", 0, quantizer, coding=scene.coding), av.CodecContext.create(scene.coding, "r")
    size, likeness, took = 0, [], 0.0
    for number, (clear, seen) in enumerate(pairs, 1):
        begun = time.thread_time()
        packet = video.packet(Shot(seen, number, 1, round(number * 1000 / scene.fps)))
        took += time.thread_time() - begun
        size += framed(packet)
        (frame,) = decoder.decode(av.Packet(unpack(packet).data))
        plane = frame.planes[0]
        shown = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)[:, : frame.width]
        likeness.append(ssim(clear, shown))
    return size, float(np.mean(likeness)), 1000 * took / len(pairs)


def equal(scene: Scene, pairs: list[Pair], wanted: float) -> tuple[int, int, float]:
    """Return the coarsest quantizer whose mean SSIM reaches what is wanted, its bytes and SSIM; the finest otherwise."""
    low, high, best = FINEST, COARSEST, None
    while low <= high:
        middle = (low + high) // 2
        size, likeness, _ = as_video(scene, pairs, middle)
        if likeness >= wanted:
            best, low = (middle, size, likeness), middle + 1
        else:
            high = middle - 1
    return best or (FINEST, *as_video(scene, pairs, FINEST)[:2])


def main() -> None:
    """Compare on every camera."""
    set_up()
    from workers.media.steps import COARSE_S, COARSER
    from workers.media.video import QUANTIZER

    beside, ratios = {}, {}
    for scene in (one for one in scenes() if one.name.startswith(ROBOT)):
        pairs = scene.take(round(60 * MINUTES * scene.fps))
        jpeg_bytes, jpeg_ssim = as_jpeg(scene, pairs)
        quantizer, size, likeness = equal(scene, pairs, jpeg_ssim)
        sent, sent_ssim, took_ms = as_video(scene, pairs, scene.quantizer or QUANTIZER)
        few = pairs[:: max(1, round(scene.fps * COARSE_S))]
        coarse, _, _ = as_video(scene, few, max(scene.quantizer or QUANTIZER, COARSER))
        reached = likeness >= jpeg_ssim
        ratios[scene.name] = jpeg_bytes / size if reached else 0.0
        kb = {name: round(n / 1000 / MINUTES) for name, n in (("jpeg", jpeg_bytes), ("equal", size), ("sent", sent))}
        print(
            f"{scene.name}: JPEG {kb['jpeg']} kB a minute (SSIM {jpeg_ssim:.4f}); {scene.coding} at quantizer {quantizer} "
            f"{kb['equal']} kB (SSIM {likeness:.4f}{'' if reached else ', not reached'}), {jpeg_bytes / size:.1f} times "
            f"fewer; as sent, {scene.quantizer or QUANTIZER}: {kb['sent']} kB (SSIM {sent_ssim:.4f}), "
            f"{jpeg_bytes / sent:.1f} times fewer; coarse {coarse / 1000 / MINUTES:.0f} kB; {took_ms:.1f} ms a picture",
            flush=True,
        )
        beside[scene.name] = {
            "jpeg_kB": kb["jpeg"], "coding": scene.coding, "video_kB": kb["equal"], "times": round(ratios[scene.name], 2),
            "sent_kB": kb["sent"], "ssim": round(jpeg_ssim, 4), "sent_ssim": round(sent_ssim, 4),
            "coarse_kB": round(coarse / 1000 / MINUTES), "encode_ms": round(took_ms, 1),
        }  # fmt: skip
    worst = min(ratios.values())
    tell(
        "stream_bytes",
        worst,
        "times fewer bytes than JPEG at equal SSIM, of the worst scene",
        f">= {GOAL:g}",
        worst >= GOAL,
        beside,
    )


if __name__ == "__main__":
    main()
