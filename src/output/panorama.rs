//! Writes equirectangular pictures with the metadata that viewers read: the Photo Sphere XMP properties `GPano`, and VR
//! photos (`.vr.jpg`), which hold both eyes.

use std::path::Path;

use super::Batch;
#[cfg(feature = "png")]
use super::PngRows;
#[cfg(feature = "jpeg")]
use super::jpeg::{segment, with_segments};
#[cfg(feature = "jpeg")]
use crate::StereoPair;
use crate::{Error, Pose, Span, View};

/// Begin of a JPEG segment that holds XMP.
#[cfg(feature = "jpeg")]
const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";
/// Begin of a JPEG segment that holds a part of the extended XMP.
#[cfg(feature = "jpeg")]
const EXTENDED_XMP: &[u8] = b"http://ns.adobe.com/xmp/extension/\0";
/// Maximum size of a part of the extended XMP: a segment's size, without its length and header.
#[cfg(feature = "jpeg")]
const PART: usize = 65_535 - 2 - EXTENDED_XMP.len() - 32 - 8;
#[cfg(feature = "jpeg")]
const APP1: u8 = 0xe1;

impl Batch {
    /// Adds a view of an equirectangular pair as a PNG file that names its projection (XMP, `GPano`).
    ///
    /// # Errors
    /// [`Error::Camera`] for a planar pose, and the errors of [`Batch::add_png`].
    #[cfg(feature = "png")]
    pub fn add_panorama_png(&mut self, path: impl AsRef<Path>, view: &View, pose: &Pose) -> Result<(), Error> {
        let mut rows = PngRows::panorama(path, pose)?;
        rows.write(&view.rgba8)?;
        self.add_png_rows(rows)
    }

    /// Adds a view of an equirectangular pair as a JPEG file that names its projection (XMP, `GPano`).
    ///
    /// # Errors
    /// [`Error::Camera`] for a planar pose, and the errors of [`Batch::add_jpeg`].
    #[cfg(feature = "jpeg")]
    pub fn add_panorama_jpeg(
        &mut self,
        path: impl AsRef<Path>,
        view: &View,
        quality: u8,
        pose: &Pose,
    ) -> Result<(), Error> {
        let path = path.as_ref();
        let jpeg = view.picture().jpeg(path, quality)?;
        let xmp = segment(APP1, &[XMP, xmp(pose)?.as_bytes()]);
        self.add(path, &with_segments(&jpeg, &xmp))
    }

    /// Adds an equirectangular pair as a VR photo, `NAME.vr.jpg`: a JPEG file of the left view, whose extended XMP
    /// holds a JPEG file of the right view (`GImage:Data`).
    ///
    /// # Errors
    /// As [`Batch::add_panorama_jpeg`], and [`Error::Io`] for a right view of 4 GiB.
    #[cfg(feature = "jpeg")]
    pub fn add_vr_jpeg(&mut self, path: impl AsRef<Path>, pair: &StereoPair, quality: u8) -> Result<(), Error> {
        use base64::{Engine, engine::general_purpose::STANDARD};
        use md5::{Digest, Md5};

        let path = path.as_ref();
        let [left, right] = [&pair.left, &pair.right].map(|view| view.picture().jpeg(path, quality));
        let data = STANDARD.encode(right?);
        let image = r#"xmlns:GImage="http://ns.google.com/photos/1.0/image/""#;
        let extended = description(&format!("{image} GImage:Data=\"{data}\""));
        let length = u32::try_from(extended.len());
        let length = length.map_err(|_| Error::unwritable(path, "the right view must be smaller than 4 GiB"))?;
        let name: String = Md5::digest(&extended).iter().map(|byte| format!("{byte:02X}")).collect();
        let note = format!(
            r#"xmlns:xmpNote="http://ns.adobe.com/xmp/note/" {image} xmpNote:HasExtendedXMP="{name}" GImage:Mime="image/jpeg""#
        );
        let main = packet(&format!("{} {note}", properties(&pair.pose)?));
        let mut segments = segment(APP1, &[XMP, main.as_bytes()]);
        for (index, part) in extended.as_bytes().chunks(PART).enumerate() {
            let offset = (index * PART) as u32;
            let header: [&[u8]; 4] = [EXTENDED_XMP, name.as_bytes(), &length.to_be_bytes(), &offset.to_be_bytes()];
            segments.extend(segment(APP1, &[&header.concat(), part]));
        }
        self.add(path, &with_segments(&left?, &segments))
    }
}

/// Returns the XMP packet that names the projection of a pose's views.
pub(super) fn xmp(pose: &Pose) -> Result<String, Error> {
    Ok(packet(&properties(pose)?))
}

/// Returns the `GPano` properties of a view, as attributes. Half a turn is cropped from a full one.
fn properties(pose: &Pose) -> Result<String, Error> {
    let Some(projection) = pose.projection.equirectangular() else {
        return Err(Error::Camera {
            field: "projection",
            value: "planar".into(),
            reason: "only equirectangular pictures are panoramas",
        });
    };
    let [width, height] = pose.size;
    let (full, left) = match projection.span {
        Span::Full => (u64::from(width), 0),
        Span::Half => (2 * u64::from(width), width / 2),
    };
    Ok(format!(
        "xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\" GPano:UsePanoramaViewer=\"True\" \
         GPano:ProjectionType=\"equirectangular\" GPano:CroppedAreaImageWidthPixels=\"{width}\" \
         GPano:CroppedAreaImageHeightPixels=\"{height}\" GPano:FullPanoWidthPixels=\"{full}\" \
         GPano:FullPanoHeightPixels=\"{height}\" GPano:CroppedAreaLeftPixels=\"{left}\" \
         GPano:CroppedAreaTopPixels=\"0\""
    ))
}

/// Returns an XMP document with these attributes.
fn description(attributes: &str) -> String {
    format!(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
         <rdf:Description rdf:about=\"\" {attributes}/></rdf:RDF></x:xmpmeta>"
    )
}

/// Returns an XMP packet with these attributes.
fn packet(attributes: &str) -> String {
    let begin = "<?xpacket begin=\"\u{feff}\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>";
    format!("{begin}{}<?xpacket end=\"r\"?>", description(attributes))
}

#[cfg(all(feature = "jpeg", feature = "png"))]
#[cfg(test)]
mod tests {
    use base64::{Engine, engine::general_purpose::STANDARD};

    use super::*;
    use crate::{
        Equirectangular, MISS, Projection, Statistics, StereoCamera, folder::Folder, glam::Vec3, random::Random,
    };

    fn pair(span: Span, [width, height]: [u32; 2]) -> StereoPair {
        let camera = StereoCamera::look_at(Vec3::ZERO, Vec3::X).size(width, height);
        let pose = camera.projection(Projection::Equirectangular(Equirectangular::new(span))).pose().unwrap();
        let mut random = Random::new(3);
        let mut view = || View {
            width,
            height,
            rgba8: (0..width * height).map(|_| [0; 4].map(|_: u8| (255.0 * random.unit()) as u8)).collect(),
            linear: Vec::new(),
            depth: Vec::new(),
            primitive: vec![MISS; 0],
            object: Vec::new(),
            albedo: Vec::new(),
            cost: Vec::new(),
        };
        let (left, right) = (view(), view());
        let statistics = Statistics::default();
        StereoPair { left, right, source: Vec::new(), shadow_source: Vec::new(), statistics, pose }
    }

    /// Writes a file, and returns its bytes.
    fn written(folder: &Folder, name: &str, add: impl FnOnce(&mut Batch, &Path) -> Result<(), Error>) -> Vec<u8> {
        let path = folder.file(name);
        let mut batch = Batch::new();
        add(&mut batch, &path).unwrap();
        batch.commit().unwrap();
        std::fs::read(path).unwrap()
    }

    /// Returns the contents of a JPEG file's APP1 segments, up to the first table.
    fn app1(jpeg: &[u8]) -> Vec<&[u8]> {
        let (mut at, mut found) = (2, Vec::new());
        while jpeg[at] == 0xff && (0xe0..=0xef).contains(&jpeg[at + 1]) {
            let end = at + 2 + usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]]));
            if jpeg[at + 1] == APP1 {
                found.push(&jpeg[at + 4..end]);
            }
            at = end;
        }
        found
    }

    fn attribute<'a>(xmp: &'a str, name: &str) -> &'a str {
        let value = xmp.split_once(&format!("{name}=\"")).unwrap_or_else(|| panic!("{name} in {xmp}")).1;
        value.split_once('"').unwrap().0
    }

    /// Reads a VR photo as its format's description says, in parts of extended XMP (Adobe, XMP Specification Part 3).
    #[test]
    fn a_vr_photo_holds_both_views() {
        let folder = Folder::new("vr_photo");
        // The right view's file fills several parts.
        let pair = pair(Span::Half, [256, 256]);
        let bytes = written(&folder, "a.vr.jpg", |batch, path| batch.add_vr_jpeg(path, &pair, 100));
        let segments = app1(&bytes);
        assert!(segments.len() > 3, "{}", segments.len());
        let main = std::str::from_utf8(segments[0].strip_prefix(XMP).unwrap()).unwrap();
        let expected = [("ImageWidthPixels", "256"), ("LeftPixels", "128"), ("TopPixels", "0")];
        for (name, value) in expected {
            assert_eq!(attribute(main, &format!("GPano:CroppedArea{name}")), value);
        }
        assert_eq!(attribute(main, "GPano:FullPanoWidthPixels"), "512");
        assert_eq!(attribute(main, "GPano:ProjectionType"), "equirectangular");
        let name = attribute(main, "xmpNote:HasExtendedXMP");
        let mut extended = Vec::new();
        for segment in &segments[1..] {
            let part = segment.strip_prefix(EXTENDED_XMP).unwrap().strip_prefix(name.as_bytes()).unwrap();
            let number = |at: usize| u32::from_be_bytes(part[at..at + 4].try_into().unwrap()) as usize;
            assert_eq!(number(4), extended.len());
            extended.extend_from_slice(&part[8..]);
            assert!(number(0) >= extended.len());
        }
        let extended = String::from_utf8(extended).unwrap();
        let right = STANDARD.decode(attribute(&extended, "GImage:Data")).unwrap();
        assert_eq!(attribute(main, "GImage:Mime"), "image/jpeg");
        let right_alone = written(&folder, "r.jpg", |batch, path| batch.add_jpeg(path, &pair.right.picture(), 100));
        assert_eq!(right, right_alone);
        let left_alone = written(&folder, "l.jpg", |batch, path| batch.add_jpeg(path, &pair.left.picture(), 100));
        let pixels = |bytes: &[u8]| image::load_from_memory(bytes).unwrap().into_rgb8();
        assert_eq!(pixels(&bytes), pixels(&left_alone));
    }

    #[test]
    fn views_name_their_projection() {
        let folder = Folder::new("panorama");
        let pair = pair(Span::Full, [64, 32]);
        let add = |batch: &mut Batch, path: &Path| batch.add_panorama_jpeg(path, &pair.left, 90, &pair.pose);
        let jpeg = written(&folder, "a.jpg", add);
        let xmp = std::str::from_utf8(app1(&jpeg)[0].strip_prefix(XMP).unwrap()).unwrap().to_owned();
        let png = written(&folder, "a.png", |batch, path| batch.add_panorama_png(path, &pair.left, &pair.pose));
        let reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().unwrap();
        let text = &reader.info().utf8_text[0];
        assert_eq!((text.keyword.as_str(), text.get_text().unwrap()), ("XML:com.adobe.xmp", xmp.clone()));
        for (name, value) in [("FullPanoWidthPixels", "64"), ("FullPanoHeightPixels", "32")] {
            assert_eq!(attribute(&xmp, &format!("GPano:{name}")), value);
        }
        let planar = StereoCamera::look_at(Vec3::ZERO, Vec3::X).pose().unwrap();
        let error = Batch::new().add_panorama_png("a.png", &pair.left, &planar).unwrap_err().to_string();
        assert!(error.contains("only equirectangular pictures"), "{error}");
    }
}
