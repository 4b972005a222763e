#include "tests/bench/pair_finder.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>

namespace zoned::bench {

namespace {

btVector3 corner_of(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

/// Bullet's broadphases keep a cache of pairs from step to step and forget old ones little by
/// little.
class BulletPairs : public PairFinder {
  public:
    BulletPairs(std::unique_ptr<btBroadphaseInterface> broadphase, std::span<const Aabb> boxes)
        : dispatcher_(&configuration_),
          broadphase_(std::move(broadphase)),
          rows_(boxes.size()) {
        for (std::uint32_t row = 0; row < boxes.size(); ++row) {
            rows_[row] = row;
            proxies_.push_back(broadphase_->createProxy(corner_of(boxes[row].lower),
                                                        corner_of(boxes[row].upper),
                                                        BOX_SHAPE_PROXYTYPE,
                                                        &rows_[row],
                                                        1,
                                                        1,
                                                        &dispatcher_));
        }
    }

    BulletPairs(const BulletPairs&) = delete;
    BulletPairs& operator=(const BulletPairs&) = delete;

    ~BulletPairs() override {
        for (btBroadphaseProxy* proxy : proxies_) {
            broadphase_->destroyProxy(proxy, &dispatcher_);
        }
    }

    void step(std::span<const std::uint32_t> moved, std::span<const Aabb> boxes) override {
        for (const std::uint32_t row : moved) {
            broadphase_->setAabb(proxies_[row],
                                 corner_of(boxes[row].lower),
                                 corner_of(boxes[row].upper),
                                 &dispatcher_);
        }
        broadphase_->calculateOverlappingPairs(&dispatcher_);
    }

    [[nodiscard]] std::vector<BoxPair> pairs() const override {
        std::vector<BoxPair> found;
        const btBroadphasePairArray& cached =
            broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
        for (int i = 0; i < cached.size(); ++i) {
            const auto a = *static_cast<const std::uint32_t*>(cached[i].m_pProxy0->m_clientObject);
            const auto b = *static_cast<const std::uint32_t*>(cached[i].m_pProxy1->m_clientObject);
            found.emplace_back(std::min(a, b), std::max(a, b));
        }
        return found;
    }

  private:
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    std::unique_ptr<btBroadphaseInterface> broadphase_;
    std::vector<std::uint32_t> rows_;
    std::vector<btBroadphaseProxy*> proxies_;
};

/// The world that sweep and prune quantises, m.
constexpr btScalar kWorldHalf = 2000;
/// Most boxes that its 16-bit handles allow.
constexpr unsigned short kHandles = 16384;

}  // namespace

std::vector<PairMethod> bullet_pair_methods() {
    return {{"default",
             "bullet",
             [](std::span<const Aabb> boxes) {
                 return std::make_unique<BulletPairs>(std::make_unique<btDbvtBroadphase>(), boxes);
             }},
            {"axis_sweep", "bullet", [](std::span<const Aabb> boxes) {
                 const btVector3 half(kWorldHalf, kWorldHalf, kWorldHalf);
                 return std::make_unique<BulletPairs>(
                     std::make_unique<btAxisSweep3>(-half, half, kHandles), boxes);
             }}};
}

}  // namespace zoned::bench
