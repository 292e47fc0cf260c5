"""The bouncing ball in 50 digits, written from the equations of motion alone: shares no formula with the kernels.

Contacts are found by scanning the gap on a fine grid and bisecting; the scatter's draws are taken as given numbers.
"""

import mpmath as mp

GRID = 400  # samples of the gap per half cycle: flights here are transversal and thousands of samples long


class Reference:
    def __init__(self, params, state, digits=50):
        mp.mp.dps = digits
        self.p = {name: mp.mpf(float(params[name])) for name in params.dtype.names}
        self.x, self.z, self.u, self.w = (mp.mpf(float(state[k])) for k in ("x", "z", "u", "w"))
        self.old = [mp.mpf(float(v)) for v in state["motion"]]
        self.impacts = []

    def bar(self, new, s):
        """(x, tilt, z) of the bar at time s of the cycle."""
        w, blend = self.p["omega"], self.p["blend"] * self.p["period"]
        u = min(s / blend, mp.mpf(1))
        weight = u * u * (3 - 2 * u)
        m = [a + weight * (b - a) for a, b in zip(self.old, new, strict=True)]
        c, sn, c2, sn2 = mp.cos(w * s), mp.sin(w * s), mp.cos(2 * w * s), mp.sin(2 * w * s)
        return m[0] * c + m[1] * sn, m[2] * c + m[3] * sn, m[4] * c2 + m[5] * sn2

    def velocity(self, new, s):
        h = mp.mpf(10) ** -15  # central difference: error h^2, 1e-30 of the scale
        a, b = self.bar(new, s + h), self.bar(new, s - h)
        return [(p - q) / (2 * h) for p, q in zip(a, b, strict=True)]

    def gap(self, new, s, since):
        """Distance of the flying ball from the surface, along its normal."""
        t = s - since
        bx, tilt, bz = self.bar(new, s)
        x, z = self.x + self.u * t, self.z + self.w * t - self.p["gravity"] * t * t / 2
        return (x - bx) * mp.sin(tilt) + (z - bz) * mp.cos(tilt)

    def cycle(self, new, draws):
        """One base cycle; `draws(i)` gives restitution and normal deviation of impact i."""
        new = [mp.mpf(float(v)) for v in new]
        s, period = mp.mpf(0), self.p["period"]
        step = period / 2 / GRID
        just_left = False
        while True:
            a = s + step / 1000 if just_left else s
            b = a + step
            while b < period and self.gap(new, b, s) > 0:
                a, b = b, b + step
            b = min(b, period)
            if self.gap(new, b, s) > 0:
                self.fly(period - s)
                break
            t = self.root(new, s, a, b)
            self.fly(t - s)
            s, just_left = t, True
            self.collide(new, s, *draws(len(self.impacts)))
        self.old = new

    def root(self, new, s, a, b):
        """The contact between a and b of the flight that began at s."""
        return mp.findroot(
            lambda t: self.gap(new, t, s), (a, b), solver="illinois", tol=mp.mpf(10) ** -80, verify=False
        )

    def fly(self, t):
        self.x += self.u * t
        self.z += self.w * t - self.p["gravity"] * t * t / 2
        self.w -= self.p["gravity"] * t

    def collide(self, new, s, restitution, deviation):
        (bx, tilt, bz), (vx, vt, vz) = self.bar(new, s), self.velocity(new, s)
        rx, rz = self.x - bx, self.z - bz
        u, w = self.u - (vx + vt * rz), self.w - (vz - vt * rx)
        n = (mp.sin(tilt + deviation), mp.cos(tilt + deviation))
        t = (n[1], -n[0])
        normal, tangent = u * n[0] + w * n[1], u * t[0] + w * t[1]
        d_n, d_t = -(1 + restitution) * normal, -self.p["tangential_loss"] * tangent
        self.u += d_n * n[0] + d_t * t[0]
        self.w += d_n * n[1] + d_t * t[1]
        self.impacts.append((s, self.x, self.z))
