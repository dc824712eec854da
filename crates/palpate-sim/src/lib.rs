//! Scene files, the sampled-data loop and replay of recorded motion for palpate
