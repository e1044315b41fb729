// First hits of pixels that show mirrors, glass or veils.

//! use counters, lane, planes, rays, view

// Returns the hits of pixels' own rays. A hit may be reused from another view's sample. If this pixel's own ray hits
// the same primitive, that t replaces the sample's. Without this, reflected rays would begin beside the pixel.
fn own_hits(pixels: Pixels, own: Rays) -> Hits {
    var hits = target_hits(pixels, B(true));
    if COUNT { primitives_tested += 1u; }
    let met = met_at(hits.slot, own);
    hits.t = select(hits.t, met.t, met.hit & (met.t >= F(0.0)));
    return hits;
}
