//! Images in memory and on disk: planes, EXR, PNG, the tone curve.
