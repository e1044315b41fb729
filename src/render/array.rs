//! Pairs of the views of camera arrays: of one rig, and of two rigs one above the other.

use crate::{
    Error, Method, Pose, Projection, RigView, Statistics, StereoCamera, StereoPair, View, Views,
    view::camera::{Field, Frustum},
};

impl Views {
    /// Returns two of the views as a stereo pair, for ground truth, layers and flow. `left` and `right` are their
    /// places in [`Views::views`]. Sources of pixels are those of the rig's view, and the statistics have no times.
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Renderer, Rig, blocking::Wait};
    ///
    /// let (scene, camera) = (Builtin::Near.scene(), Builtin::Near.camera(64, 48));
    /// let mut renderer = Renderer::new(Gpu::new().wait()?);
    /// let uploaded = renderer.upload(&scene).wait()?;
    /// let views = renderer.views(&uploaded, &Rig::row(camera, 4)).read().wait()?;
    /// let pair = views.pair(0, 3)?;
    /// let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait()?;
    /// assert_eq!(truth.pose.interaxial, 3.0 * views.pose.interaxial);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Rig`] for a view that is not there, for a left view that is not to the left of the right one, and for
    /// views of all directions, which have no pairs but their own.
    pub fn pair(&self, left: usize, right: usize) -> Result<StereoPair, Error> {
        let frustum = self.frustum()?;
        let (one, other) = (self.view(left)?, self.view(right)?);
        let [a, b] = [one, other].map(|view| view.offset * self.pose.interaxial);
        if a >= b {
            return fault(format!("view {left} is not to the left of view {right}"));
        }
        let middle = 0.5 * (f64::from(one.offset) + f64::from(other.offset));
        let apart = other.offset - one.offset;
        let [x, y] = frustum.center;
        let field =
            Frustum { center: [x - middle * frustum.shift, y], shift: f64::from(apart) * frustum.shift, ..frustum };
        let pose = Pose {
            eye: self.pose.eye + self.pose.right.as_dvec3() * (0.5 * (f64::from(a) + f64::from(b))),
            interaxial: b - a,
            interaxial_px: apart * self.pose.interaxial_px,
            field: Field::Screen(field),
            ..self.pose
        };
        Ok(pair_of(pose, [one, other], View::clone))
    }

    /// Returns a view and a view of a lower camera as a stereo pair: the pictures of a rig that is turned by 90
    /// degrees. All its pictures are turned counterclockwise, so that rows are epipolar lines. The upper view is the
    /// left one. Pixel (i, j) of a turned picture is pixel (w - 1 - j, i) of the view.
    ///
    /// `lower` is rendered by the same rig, lowered by [`StereoCamera::raised`]. The cameras of the pair are parallel.
    ///
    /// # Errors
    /// [`Error::Rig`] for views that are not there, of another size, or not exactly one above the other.
    pub fn pair_below(&self, upper: usize, lower: (&Self, usize)) -> Result<StereoPair, Error> {
        let frustum = self.frustum()?;
        let (below, lower) = lower;
        let views = [self.view(upper)?, below.view(lower)?];
        let (pose, other) = (&self.pose, &below.pose);
        let down = pose.eye - other.eye;
        let height = down.dot(pose.up.as_dvec3());
        let aside = (down - pose.up.as_dvec3() * height).length();
        let is_alike = (pose.right, pose.up, pose.size, pose.field) == (other.right, other.up, other.size, other.field);
        if !is_alike || views[0].offset != views[1].offset || height <= 0.0 || aside > 1e-6 * height {
            return fault("the second view must be below the first one, with the same camera and offset".into());
        }
        let offset = f64::from(views[0].offset);
        let [[x, y], [w, h]] = [frustum.center, frustum.size];
        let eye = pose.eye + pose.right.as_dvec3() * f64::from(views[0].offset * pose.interaxial);
        let turned = Pose {
            eye: eye - pose.up.as_dvec3() * (0.5 * height),
            right: -pose.up,
            up: pose.right,
            screen_distance: f32::INFINITY,
            screen_size: [f32::INFINITY; 2],
            interaxial: height as f32,
            interaxial_px: 0.0,
            size: [pose.size[1], pose.size[0]],
            field: Field::Screen(Frustum {
                size: [h, w],
                center: [-y, x - offset * frustum.shift],
                shift: 0.0,
                ..frustum
            }),
            ..*pose
        };
        Ok(pair_of(turned, views, View::turned))
    }

    fn view(&self, index: usize) -> Result<&RigView, Error> {
        let views = self.views.len();
        self.views.get(index).map_or_else(|| fault(format!("there is no view {index}; there are {views}")), Ok)
    }

    fn frustum(&self) -> Result<Frustum, Error> {
        match self.pose.frustum() {
            Some(frustum) if self.pose.projection == Projection::OffAxis => Ok(frustum),
            _ => fault("only planar views that are not toed in have pairs".into()),
        }
    }
}

fn fault<T>(reason: String) -> Result<T, Error> {
    Err(Error::Rig { reason })
}

fn pair_of(pose: Pose, [left, right]: [&RigView; 2], view: impl Fn(&View) -> View) -> StereoPair {
    // A traced view shows each pixel's own surface, as with naive.
    let is_exact = |method| matches!(method, Method::Naive | Method::Bracket(_));
    let method = if is_exact(right.method) { left.method } else { right.method };
    StereoPair {
        left: view(&left.view),
        right: view(&right.view),
        source: right.source.clone(),
        shadow_source: right.shadow_source.clone(),
        statistics: Statistics { method, left: left.work, right: right.work, ..Statistics::default() },
        pose,
    }
}

impl View {
    /// Returns the view turned counterclockwise by 90 degrees.
    fn turned(&self) -> Self {
        let [width, height] = [self.width as usize, self.height as usize];
        fn list<T: Copy>(list: &[T], width: usize, height: usize) -> Vec<T> {
            let is_there = usize::from(!list.is_empty());
            let rows = (0..width * is_there).rev();
            rows.flat_map(|column| (0..height).map(move |row| list[row * width + column])).collect()
        }
        Self {
            width: self.height,
            height: self.width,
            rgba8: list(&self.rgba8, width, height),
            linear: list(&self.linear, width, height),
            albedo: list(&self.albedo, width, height),
            depth: list(&self.depth, width, height),
            primitive: list(&self.primitive, width, height),
            object: list(&self.object, width, height),
            cost: list(&self.cost, width, height),
        }
    }
}

impl Pose {
    /// Returns a camera with this pose. Its rays differ from the pose's by rounding.
    ///
    /// # Errors
    /// [`Error::Camera`] for equirectangular pictures, and as [`StereoCamera::pose`].
    pub fn camera(&self) -> Result<StereoCamera, Error> {
        let target = self.eye + self.forward.as_dvec3() * f64::from(self.subject_distance);
        let camera = StereoCamera::look_at(self.eye, target)
            .up(self.up)
            .size(self.size[0], self.size[1])
            .intrinsics(self.planar_intrinsics()?)
            .interaxial(self.interaxial);
        camera.pose()?;
        Ok(camera)
    }
}

impl StereoCamera {
    /// Returns the camera moved up along the picture's up axis, by a distance in world units; down by a negative one.
    /// It looks in the same direction. Rigs of cameras at several heights are a grid ([`Views::pair_below`]).
    ///
    /// # Errors
    /// [`Error::Camera`] as [`StereoCamera::pose`].
    pub fn raised(self, distance: f64) -> Result<Self, Error> {
        let step = self.pose()?.up.as_dvec3() * distance;
        let (eye, target) = (self.eye_position() + step, self.target_position() + step);
        let raised = self.eye(eye).target(target);
        raised.pose()?;
        Ok(raised)
    }
}
