// Axis choice: the rule by which separating axis tests choose among nearly equal axes.
#pragma once

namespace zoned::physics {

/// The other kind of feature must win by this much. So a resting contact does not flip between
/// descriptions that are equally good, and keeps its warm start. In metres for bodies of half a
/// metre, less for smaller ones.
inline constexpr float kFaceBias = 5.0e-4F;
inline constexpr float kEdgeBias = 2.0e-3F;
/// Sine of the angle under which two edges count as parallel: their cross product is then no axis
/// that the faces do not have already.
inline constexpr float kParallel = 5.0e-3F;

/// An edge runs along a face that looks along the axis of contact by more than this cosine.
inline constexpr float kAlongFace = 0.9F;
/// Ends of such a run that are nearer to where two edges cross than this are the crossing, m.
inline constexpr float kSameEnd = 1.0e-3F;
/// An end that is deeper than the crossing by more than this is not over the face, seen along the
/// axis, m.
inline constexpr float kNotOver = 1.0e-4F;
/// From this bit on names of such ends differ from that of the crossing.
inline constexpr int kRunBits = 16;

}  // namespace zoned::physics
