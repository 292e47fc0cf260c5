"""A ball on a moving sphere in 50 digits, from the distance to the sphere's centre: no formula of the kernels.

Impacts are found by scanning that distance on a fine grid and by a bracketed root finder.
"""

import mpmath as mp

GRID = 400  # samples of the distance per cycle: flights here are transversal and hundreds of samples long


def dot(a, b):
    return sum(p * q for p, q in zip(a, b, strict=True))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def along(a, b, scale):
    """a + scale b."""
    return [p + scale * q for p, q in zip(a, b, strict=True)]


class Reference:
    def __init__(self, params, state, inertia_ratio=None, friction=None, digits=50):
        mp.mp.dps = digits
        names = ("gravity", "frequency", "acceleration", "phase", "restitution", "tangential_loss")
        p = {name: mp.mpf(float(getattr(params, name))) for name in names}
        self.omega = 2 * mp.pi * p["frequency"]
        self.period = 1 / p["frequency"]
        self.amplitude = p["acceleration"] / self.omega**2
        self.p, self.inertia_ratio, self.friction = p, inertia_ratio, friction
        # the sphere on which the ball's centre moves; the side is +1 for a ball inside it
        radius = 1 / mp.mpf(params.curvature) - mp.mpf(params.ball_radius)
        self.radius, self.side = abs(radius), mp.sign(radius)
        self.place = [mp.mpf(getattr(state, k)) for k in ("x", "y", "z")]
        self.velocity = [mp.mpf(getattr(state, k)) for k in ("u", "v", "w")]
        self.spin = [mp.mpf(getattr(state, k)) for k in ("spin_x", "spin_y", "spin_z")]
        self.impacts = []

    def from_centre(self, s, since):
        """The ball's centre seen from the sphere's, at time s of a flight that began at `since`."""
        t = s - since
        lens = self.amplitude * mp.sin(self.omega * s + self.p["phase"])
        x, y, z = along(self.place, self.velocity, t)
        return [x, y, z - self.p["gravity"] * t * t / 2 - lens - self.side * self.radius]

    def gap(self, s, since):
        offset = self.from_centre(s, since)
        return self.side * (self.radius - mp.sqrt(dot(offset, offset)))

    def root(self, a, b, since):
        """The impact between a and b of the flight that began at `since`."""
        return mp.findroot(lambda t: self.gap(t, since), (a, b), solver="illinois", tol=mp.mpf(10) ** -80, verify=False)

    def fly(self, t):
        self.place = along(self.place, self.velocity, t)
        self.place[2] -= self.p["gravity"] * t * t / 2
        self.velocity[2] -= self.p["gravity"] * t

    def cycle(self, number):
        s, step, just_left = mp.mpf(0), self.period / GRID, False
        while True:
            a = s + step / 1000 if just_left else s
            b = a + step
            while b < self.period and self.gap(b, s) > 0:
                a, b = b, b + step
            b = min(b, self.period)
            if self.gap(b, s) > 0:
                self.fly(self.period - s)
                return
            since = s
            s = self.root(a, b, since)
            normal = [-self.side * q / self.radius for q in self.from_centre(s, since)]
            self.fly(s - since)
            just_left = True
            self.collide(s, normal)
            self.impacts.append((number, s, *self.place))

    def collide(self, s, normal):
        lens = [0, 0, self.omega * self.amplitude * mp.cos(self.omega * s + self.p["phase"])]
        relative = along(self.velocity, lens, -1)
        approach = dot(relative, normal)
        tangent = along(relative, normal, -approach)
        jump = along([0, 0, 0], normal, -(1 + self.p["restitution"]) * approach)
        if self.inertia_ratio is None:
            jump = along(jump, tangent, -self.p["tangential_loss"])
        else:
            # the impulse per mass j at -R n changes R spin by -(n x j) / k and stops the slip
            k = mp.mpf(self.inertia_ratio)
            slip = along(tangent, cross(self.spin, normal), -1)
            impulse = [-k / (1 + k) * q for q in slip]
            if self.friction is not None:
                impulse = [(1 + mp.mpf(self.friction.restitution)) * q for q in impulse]
                most = mp.mpf(self.friction.coefficient) * mp.sqrt(dot(jump, jump))
                size = mp.sqrt(dot(impulse, impulse))
                impulse = [min(1, most / size) * q for q in impulse]
            jump = along(jump, impulse, 1)
            self.spin = along(self.spin, cross(normal, impulse), -1 / k)
        self.velocity = along(self.velocity, jump, 1)
