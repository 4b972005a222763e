#include "server/spatial/box_index.h"
#include "tests/bench/pair_finder.h"

#include <algorithm>
#include <numeric>

namespace zoned::bench {

namespace {

class SpatialPairs : public PairFinder {
  public:
    SpatialPairs(spatial::BroadphaseKind kind, std::span<const Aabb> boxes)
        : index_(kind, spatial::BroadphaseSettings()),
          moves_(boxes.size(), 0) {
        index_.reserve(boxes.size());
        for (std::uint32_t row = 0; row < boxes.size(); ++row) {
            index_.insert(row, boxes[row]);
        }
    }

    void step(std::span<const std::uint32_t> moved, std::span<const Aabb> boxes) override {
        index_.update(moved, boxes);
        for (const std::uint32_t row : moved) {
            moves_[row] = 1;
        }
        pairs_.clear();
        index_.query_each(moved, boxes, [this](std::uint32_t row, std::uint32_t other) {
            // Two rows that both moved find each other twice.
            if (other > row || moves_[other] == 0) {
                pairs_.emplace_back(std::min(row, other), std::max(row, other));
            }
        });
        for (const std::uint32_t row : moved) {
            moves_[row] = 0;
        }
    }

    [[nodiscard]] std::vector<BoxPair> pairs() const override { return pairs_; }

  private:
    spatial::BoxIndex index_;
    std::vector<std::uint8_t> moves_;  // by row
    std::vector<BoxPair> pairs_;
};

}  // namespace

std::vector<PairMethod> spatial_methods() {
    using Kind = spatial::BroadphaseKind;
    std::vector<PairMethod> methods;
    methods.push_back({"default", "", [](std::span<const Aabb> boxes) {
                           const auto count = static_cast<std::uint32_t>(boxes.size());
                           return std::make_unique<SpatialPairs>(spatial::choose_kind(count),
                                                                 boxes);
                       }});
    for (const Kind kind : {Kind::kAllPairs,
                            Kind::kGrid,
                            Kind::kOctree,
                            Kind::kQuadtree,
                            Kind::kSortAndSweep,
                            Kind::kTree}) {
        methods.push_back(
            {std::string(spatial::name_of(kind)), "", [kind](std::span<const Aabb> boxes) {
                 return std::make_unique<SpatialPairs>(kind, boxes);
             }});
    }
    return methods;
}

}  // namespace zoned::bench
