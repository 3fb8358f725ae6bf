// The wall times of the last frames as bars, with a line at the frame of 60 Hz.

const frameMs = 1000 / 60;
const mostMs = 2 * frameMs;

export class Graph {
  times = [];

  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d');
  }

  add(ms) {
    this.times.push(ms);
    if (this.times.length > this.canvas.width) this.times.shift();
  }

  /** The middle one of the times shown. */
  get median() { return [...this.times].sort((a, b) => a - b)[this.times.length >> 1] ?? 0; }

  draw() {
    const { context: c, canvas } = this;
    const { width, height } = canvas;
    const y = (ms) => height - (Math.min(ms, mostMs) / mostMs) * height;
    c.clearRect(0, 0, width, height);
    this.times.forEach((ms, k) => {
      c.fillStyle = ms > frameMs ? '#e07a6a' : '#5b9bd5';
      c.fillRect(k, y(ms), 1, height - y(ms));
    });
    c.fillStyle = '#c9d2dc80';
    c.fillRect(0, y(frameMs), width, 1);
  }
}
