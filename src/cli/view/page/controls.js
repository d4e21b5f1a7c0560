// Mouse, touch and keys: how they move the camera.
class Controls {
  constructor(canvas, connection) {
    Object.assign(this, { canvas, connection, pointers: new Map(), keys: new Set() });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
      this.dragged = false;
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.move("dolly", { halvings: -event.deltaY / 800 });
    }, { passive: false });
    canvas.addEventListener("click", (event) => {
      if (!this.dragged) connection.ask("path", this.place(event));
    });
    canvas.addEventListener("dblclick", (event) => connection.ask("focus", this.place(event)));
    canvas.addEventListener("keydown", (event) => this.press(event));
    canvas.addEventListener("keyup", (event) => this.keys.delete(event.code));
    canvas.addEventListener("blur", () => this.keys.clear());
  }

  // Where an event is in the picture, in shares of its width and height.
  place(event) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return { x: (event.clientX - left) / width, y: (event.clientY - top) / height };
  }

  move(name, by) {
    const sum = (a, b) => Object.fromEntries(Object.entries(a).map(([key, value]) => [key, value + b[key]]));
    this.connection.ask(`move.${name}`, by, sum);
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    this.dragged = true;
    const height = this.canvas.clientHeight;
    const right = (event.clientX - before.clientX) / height;
    const down = (event.clientY - before.clientY) / height;
    const others = [...this.pointers.values()].filter((other) => other.pointerId !== event.pointerId);
    this.pointers.set(event.pointerId, event);
    if (others.length > 0) {
      const apart = (pointer) => Math.hypot(pointer.clientX - others[0].clientX, pointer.clientY - others[0].clientY);
      this.move("pan", { right: -right / 2, up: down / 2 });
      this.move("dolly", { halvings: Math.log2(Math.max(apart(event), 1) / Math.max(apart(before), 1)) });
    } else if (event.shiftKey || event.buttons & 6) {
      this.move("pan", { right: -right, up: down });
    } else if (event.ctrlKey) {
      this.move("look", { right: 60 * right, up: -60 * down });
    } else {
      this.move("orbit", { right: -180 * right, up: 180 * down });
    }
  }

  press(event) {
    const first = this.keys.size === 0;
    if (event.code === "KeyR") this.connection.ask("camera", "");
    if (!(event.code in Controls.KEYS) || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    this.keys.add(event.code);
    if (first) {
      this.before = performance.now();
      this.go(1 / 30);
      requestAnimationFrame((now) => this.hold(now));
    }
  }

  // Keys move as long as they are held.
  hold(now) {
    if (this.keys.size === 0) return;
    this.go(Math.min((now - this.before) / 1000, 0.1));
    this.before = now;
    requestAnimationFrame((next) => this.hold(next));
  }

  go(seconds) {
    for (const code of this.keys) {
      const [name, by] = Controls.KEYS[code];
      this.move(name, Object.fromEntries(Object.entries(by).map(([key, value]) => [key, value * seconds])));
    }
  }

  static fly(right, up, forward) {
    return ["fly", { right, up, forward }];
  }
}

Controls.KEYS = {
  ArrowLeft: ["orbit", { right: -60, up: 0 }],
  ArrowRight: ["orbit", { right: 60, up: 0 }],
  ArrowUp: ["orbit", { right: 0, up: 60 }],
  ArrowDown: ["orbit", { right: 0, up: -60 }],
  KeyW: Controls.fly(0, 0, 0.5),
  KeyS: Controls.fly(0, 0, -0.5),
  KeyA: Controls.fly(-0.5, 0, 0),
  KeyD: Controls.fly(0.5, 0, 0),
  KeyQ: Controls.fly(0, -0.5, 0),
  KeyE: Controls.fly(0, 0.5, 0),
  Equal: ["dolly", { halvings: 1 }],
  NumpadAdd: ["dolly", { halvings: 1 }],
  Minus: ["dolly", { halvings: -1 }],
  NumpadSubtract: ["dolly", { halvings: -1 }],
};
