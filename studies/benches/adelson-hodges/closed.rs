//! Computes rays per pixel in the worst cases of the paper's last section, level by level and in closed form.

/// Effect of a scene's surfaces on a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Surfaces {
    /// There are no surfaces.
    Misses,
    /// Surfaces send shadow rays.
    Diffuse,
    /// Surfaces send shadow rays, and reflect or refract the ray.
    DiffuseAndOne,
    /// Surfaces send shadow rays, and both reflect and refract the ray.
    DiffuseAndTwo,
    /// Surfaces reflect or refract the ray.
    One,
    /// Surfaces reflect and refract the ray.
    Two,
}

/// Depth of rays: `hit` levels of rays meet a surface (the paper's v), and at most `most` levels are traced (its L).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    pub(crate) hit: u32,
    pub(crate) most: u32,
}

impl Surfaces {
    /// All kinds, in the paper's order.
    pub(crate) const ALL: [Self; 6] =
        [Self::Misses, Self::Diffuse, Self::DiffuseAndOne, Self::DiffuseAndTwo, Self::One, Self::Two];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Misses => "misses",
            Self::Diffuse => "diffuse",
            Self::DiffuseAndOne => "reflective or refractive, and diffuse",
            Self::DiffuseAndTwo => "reflective, refractive, and diffuse",
            Self::One => "reflective or refractive, no diffuse",
            Self::Two => "reflective and refractive, no diffuse",
        }
    }

    /// Returns the paper's saving with five levels, in percent of 1 - M.
    pub(crate) fn paper(self) -> &'static str {
        match self {
            Self::Misses | Self::Diffuse => "100.0",
            Self::DiffuseAndOne | Self::One => "20.0",
            Self::DiffuseAndTwo | Self::Two => "3.226",
        }
    }

    pub(crate) fn is_diffuse(self) -> bool {
        matches!(self, Self::Diffuse | Self::DiffuseAndOne | Self::DiffuseAndTwo)
    }

    /// Returns the number of rays that a hit reflects and refracts.
    pub(crate) fn sent(self) -> u64 {
        match self {
            Self::Misses | Self::Diffuse => 0,
            Self::DiffuseAndOne | Self::One => 1,
            Self::DiffuseAndTwo | Self::Two => 2,
        }
    }

    /// Returns the number of all rays of a traced pixel.
    pub(crate) fn rays(self, levels: Levels, lights: u64) -> u64 {
        self.rays_from(1, levels, lights)
    }

    /// Returns the number of rays in the tree that starts with a ray of this level.
    fn rays_from(self, level: u32, levels: Levels, lights: u64) -> u64 {
        if self == Self::Misses || level > levels.hit {
            return 1;
        }
        let sent = if level < levels.most { self.sent() } else { 0 };
        let further = if sent > 0 { sent * self.rays_from(level + 1, levels, lights) } else { 0 };
        1 + self.shadow_rays(lights) + further
    }

    /// Returns the number of shadow rays of one hit.
    fn shadow_rays(self, lights: u64) -> u64 {
        if self.is_diffuse() { lights } else { 0 }
    }

    /// Returns the share of a reused pixel's rays that is saved: its own ray and the shadow rays of its first hit. The
    /// rays are counted level by level.
    pub(crate) fn saved(self, levels: Levels, lights: u64) -> f64 {
        (1 + self.shadow_rays(lights)) as f64 / self.rays(levels, lights) as f64
    }

    /// Returns the same share by the paper's closed forms. The printed power (1 + S)^v is read as the product (1 + S)
    /// v.
    pub(crate) fn saved_in_closed_form(self, levels: Levels, lights: u64) -> f64 {
        let (v, s) = (f64::from(levels.hit), lights as f64);
        let cut = levels.hit == levels.most;
        match self {
            Self::Misses | Self::Diffuse => 1.0,
            Self::DiffuseAndOne if cut => 1.0 / v,
            Self::DiffuseAndOne => (1.0 + s) / ((1.0 + s) * v + 1.0),
            Self::DiffuseAndTwo if cut => 1.0 / (v.exp2() - 1.0),
            Self::DiffuseAndTwo => (1.0 + s) / ((v.exp2() - 1.0) * (1.0 + s) + v.exp2()),
            Self::One if cut => 1.0 / v,
            Self::One => 1.0 - v / (v + 1.0),
            Self::Two if cut => 1.0 / (v.exp2() - 1.0),
            Self::Two => 1.0 / ((v + 1.0).exp2() - 1.0),
        }
    }
}
