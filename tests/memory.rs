//! Files in memory: the same pictures and errors as of the same files on the disk.
#![cfg(feature = "textures")]

mod common;

use common::folder::Folder;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use stereotrace::{Limits, Texture};

fn png(pixels: &[[u8; 4]]) -> Vec<u8> {
    let (mut bytes, width) = (Vec::new(), pixels.len() as u32);
    PngEncoder::new(&mut bytes).write_image(pixels.as_flattened(), width, 1, ExtendedColorType::Rgba8).unwrap();
    bytes
}

#[test]
fn pictures_are_read_from_bytes() {
    let folder = Folder::new("memory_pictures");
    let bytes = png(&[[9, 8, 7, 255], [6, 5, 4, 255]]);
    let path = folder.write("a.png", &bytes);
    let read = |bytes: &[u8], limits: &Limits| Texture::from_bytes("a.png", bytes, limits);
    assert_eq!(read(&bytes, &Limits::default()).unwrap(), Texture::open(&path).unwrap());
    let said = |limits: &Limits| {
        let messages =
            [read(&bytes, limits), Texture::open_within(&path, limits)].map(|found| found.unwrap_err().to_string());
        assert!(messages[1].ends_with(&messages[0]), "{messages:?}");
        messages[0].clone()
    };
    assert!(said(&Limits::default().file_bytes(9)).starts_with("a.png: the file has"));
    assert!(said(&Limits::default().texture_pixels(1)).starts_with("a.png: the picture has 2x1 pixels"));
    assert!(read(b"", &Limits::default()).unwrap_err().to_string().starts_with("a.png: no picture of a texture"));
    #[cfg(feature = "sky")]
    {
        use stereotrace::SkyMap;

        let read = |limits: &Limits| SkyMap::from_bytes("a.png", &bytes, limits);
        assert!(read(&Limits::default()).unwrap() == SkyMap::open(&path).unwrap());
        for limits in [Limits::default().file_bytes(9), Limits::default().sky_pixels(1)] {
            let messages =
                [read(&limits), SkyMap::open_within(&path, &limits)].map(|found| found.unwrap_err().to_string());
            assert!(messages[0].starts_with("a.png: the ") && messages[1].ends_with(&messages[0]), "{messages:?}");
        }
    }
}
