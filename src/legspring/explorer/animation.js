// Moves the animal: from one picture of a stride to the next, as fast as is asked for.
const data = frames.data
const count = data.body_x.length
const show = (n) => {
  n = ((n % count) + count) % count
  clock.tags[0] = n
  const [hx, hy, fx, fy, rx, ry, force] = [data.hip_x, data.hip_y, data.foot_x, data.foot_y, data.free_x, data.free_y, data.force].map((all) => all[n])
  const width = force.map((one) => 1 + 5 * Math.abs(one) / data.strongest[0])
  const colour = force.map((one) => one >= 0 ? push : pull)
  // In place: what is only seen here is not sent to the server.
  Object.assign(legs.data, {x0: hx, y0: hy, x1: fx, y1: fy, width, colour})
  Object.assign(free.data, {x0: hx, y0: hy, x1: rx, y1: ry})
  Object.assign(body.data, {x: [data.body_x[n]], y: [data.body_y[n]]})
  Object.assign(feet.data, {x: fx, y: fy})
  Object.assign(ground.data, {x: data.mark_x[n], y: data.mark_y[n]})
  Object.assign(cursor.data, {x: [data.time[n], data.time[n]], y: [-data.strongest[0], data.strongest[0]]})
  for (const source of [legs, free, body, feet, ground, cursor]) source.change.emit()
}
clock.show = show
if (!clock.running) {
  clock.running = true
  if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) play.active = false
  let before = null, gone = 0
  const tick = (now) => {
    const there = frames.data
    if (play.active && before !== null) {
      gone += (now - before) / 1000 / slow.value
      const each = there.time[1] - there.time[0]
      if (gone > each) {
        clock.show(clock.tags[0] + Math.floor(gone / each))
        gone %= each
      }
    }
    before = now
    window.requestAnimationFrame(tick)
  }
  window.requestAnimationFrame(tick)
}
show(clock.tags[0])
