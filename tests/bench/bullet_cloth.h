// BulletCloth: the benchmark's cloth as Bullet's btSoftBody at its defaults.
#pragma once

#include "tests/scenario/cloth_scene.h"

#include <memory>
#include <vector>

namespace zoned::bench {

/// The nodes, masses, pins, springs (as links) and faces are the same. Bullet's links are
/// position-based: one takes back the share kLST of its error per pass. An implicit step of a
/// spring of stiffness k between masses of inverse w takes back w / (w + 1 / (k dt^2)), and kLST is
/// set to that. Drag becomes kDP = 1 - exp(-drag dt). Springs have no damping there. Everything
/// else is at Bullet's defaults: one pass per step.
class BulletCloth {
  public:
    /// `passes` over all links per step; Bullet's default is one.
    explicit BulletCloth(const scenario::Cloth& cloth, int passes = 1);
    ~BulletCloth();
    BulletCloth(const BulletCloth&) = delete;
    BulletCloth& operator=(const BulletCloth&) = delete;

    void step();
    [[nodiscard]] std::vector<Vec3d> nodes() const;
    [[nodiscard]] double links() const;

  private:
    struct World;
    std::unique_ptr<World> world_;
};

}  // namespace zoned::bench
