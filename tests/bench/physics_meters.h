// Meters: measurements on each physics scene, taken only from the motions that an engine reports.
#pragma once

#include "tests/bench/results.h"
#include "tests/bench/simulator.h"

#include <memory>

namespace zoned::bench {

/// Looks at a simulator after each step and fills the error columns of its row at the end.
class Meter {
  public:
    Meter() = default;
    Meter(const Meter&) = delete;
    Meter& operator=(const Meter&) = delete;
    virtual ~Meter() = default;
    virtual void after_step(const Simulator& simulator) = 0;
    virtual void finish(const Simulator& simulator, Row& row) = 0;
};

/// S1, S2, S4: error = largest distance of a body from where it started.
std::unique_ptr<Meter> drift_meter(const scenario::Description& description);
/// S2x100, S2x1000: the same metrics; error = how far the last body's height is off.
std::unique_ptr<Meter> column_meter(const scenario::Description& description);
/// S3: error = mean penetration of overlapping pairs.
std::unique_ptr<Meter> pile_meter(const scenario::Description& description);
/// S5: error = last apex minus the drop height.
std::unique_ptr<Meter> last_apex_meter(const scenario::Description& description);
/// S5b: error = relative error of apex 6.
std::unique_ptr<Meter> apexes_meter(const scenario::Description& description);
/// S6a: error = distance slid minus the closed form.
std::unique_ptr<Meter> slide_meter(const scenario::Description& description);
/// S6b: error = distance crept.
std::unique_ptr<Meter> creep_meter(const scenario::Description& description);
/// S7: error = relative drift of kinetic energy, where it is largest.
std::unique_ptr<Meter> spin_meter(const scenario::Description& description);
/// S8: error = largest gap of a joint.
std::unique_ptr<Meter> chain_meter(const scenario::Description& description);
/// S9: error = number of spheres that passed through.
std::unique_ptr<Meter> bullets_meter(const scenario::Description& description);
/// S11: error = highest rise of a body above its place at rest, after the fall.
std::unique_ptr<Meter> drop_meter(const scenario::Description& description);
/// S12: error = way driven less the exact one.
std::unique_ptr<Meter> car_meter(const scenario::Description& description);
/// S13: error = largest speed over that of the fall.
std::unique_ptr<Meter> ragdoll_meter(const scenario::Description& description);
/// S14: error = largest gap of a joint over the length of a link.
std::unique_ptr<Meter> sheet_meter(const scenario::Description& description);
/// S15: error = largest error of a ball's velocity over the first ball's speed at the start.
std::unique_ptr<Meter> row_meter(const scenario::Description& description);
/// S15: error = kinetic energy over the exact one, less one.
std::unique_ptr<Meter> break_meter(const scenario::Description& description);
/// S15: error = energy at the end over that at the start, less one.
std::unique_ptr<Meter> cradle_meter(const scenario::Description& description);
/// S16: error = largest distance of a plate from where it started.
std::unique_ptr<Meter> card_meter(const scenario::Description& description);
/// S17: error = mean overlap of pairs that overlap, surfaces among them, at every 100th step.
std::unique_ptr<Meter> hull_meter(const scenario::Description& description);
/// S18: error = how far a ball's height is off.
std::unique_ptr<Meter> static_field_meter(const scenario::Description& description);

}  // namespace zoned::bench
