//! Rays of a pixel at the worst, as the paper's last section discusses them: counted level by level, and in closed
//! form.

/// What a scene's surfaces do with a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Surfaces {
    /// There are none.
    Misses,
    /// They ask the lights.
    Diffuse,
    /// They ask the lights, and reflect or refract the ray.
    DiffuseAndOne,
    /// They ask the lights, and both reflect and refract it.
    DiffuseAndTwo,
    /// They reflect or refract it.
    One,
    /// They reflect and refract it.
    Two,
}

/// How deep rays go: `hit` levels of rays meet a surface (the paper's v), and no more than `most` are traced (its L).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    pub(crate) hit: u32,
    pub(crate) most: u32,
}

impl Surfaces {
    /// In the paper's order.
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

    /// What the paper says is saved with five levels, percent of 1 - M.
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

    /// Rays that a hit sends on.
    pub(crate) fn sent(self) -> u64 {
        match self {
            Self::Misses | Self::Diffuse => 0,
            Self::DiffuseAndOne | Self::One => 1,
            Self::DiffuseAndTwo | Self::Two => 2,
        }
    }

    /// All rays of a pixel that is traced.
    pub(crate) fn rays(self, levels: Levels, lights: u64) -> u64 {
        self.rays_from(1, levels, lights)
    }

    /// Those that begin with a ray of a level.
    fn rays_from(self, level: u32, levels: Levels, lights: u64) -> u64 {
        if self == Self::Misses || level > levels.hit {
            return 1;
        }
        let sent = if level < levels.most { self.sent() } else { 0 };
        let further = if sent > 0 { sent * self.rays_from(level + 1, levels, lights) } else { 0 };
        1 + self.shadow_rays(lights) + further
    }

    /// Those of one hit.
    fn shadow_rays(self, lights: u64) -> u64 {
        if self.is_diffuse() { lights } else { 0 }
    }

    /// What is saved of a pixel that is carried over, its own ray and its first hit's shadow rays, as a share of all
    /// its rays: counted.
    pub(crate) fn saved(self, levels: Levels, lights: u64) -> f64 {
        (1 + self.shadow_rays(lights)) as f64 / self.rays(levels, lights) as f64
    }

    /// The same in the paper's closed forms, where it prints (1 + S)^v read as (1 + S) v.
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
