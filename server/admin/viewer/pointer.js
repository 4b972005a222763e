// Pointers and keys on the canvas move the camera, and choose what is clicked.

const CLICK_PIXELS = 6;

/** `on` has moved(), choose(x, y), key(name): whether it was one of the page's own. */
export function listen(canvas, camera, on) {
  const pointers = new Map();
  let moved = 0;
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    moved = 0;
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) {
      return;
    }
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    if (pointers.size === 2) {
      const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const span = (at) => Math.max(1, Math.hypot(at[0] - other[0], at[1] - other[1]));
      camera.zoom(span(before) / span([event.clientX, event.clientY]));
      camera.shift(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons === 2 || camera.above) {
      camera.shift(dx, dy);
    } else {
      camera.turn(dx, dy);
    }
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    moved += Math.abs(dx) + Math.abs(dy);
    on.moved(pointers.size === 2 || event.shiftKey || event.buttons === 2 || camera.above);
  });
  canvas.addEventListener('pointerup', (event) => {
    pointers.delete(event.pointerId);
    if (moved < CLICK_PIXELS && event.button === 0) {
      on.choose(event.clientX, event.clientY);
    }
  });
  canvas.addEventListener('pointercancel', (event) => pointers.delete(event.pointerId));
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(0.001 * event.deltaY));
    on.moved(false);
  }, { passive: false });
  canvas.addEventListener('keydown', (event) => {
    const turns = { ArrowLeft: [20, 0], ArrowRight: [-20, 0], ArrowUp: [0, 20], ArrowDown: [0, -20] };
    const zooms = { '+': 0.85, '-': 1.18 };
    if (turns[event.key] && (event.shiftKey || camera.above)) {
      camera.shift(...turns[event.key].map((v) => 2 * v));
      on.moved(true);
    } else if (turns[event.key]) {
      camera.turn(...turns[event.key]);
      on.moved(false);
    } else if (zooms[event.key]) {
      camera.zoom(zooms[event.key]);
      on.moved(false);
    } else if (event.ctrlKey || event.metaKey || event.altKey || !on.key(event.key)) {
      return;
    }
    event.preventDefault();
  });
}
