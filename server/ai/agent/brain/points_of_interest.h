// PointsOfInterest: the places that agents go to, their stock, and the time of day.
#pragma once

#include "server/ai/splines/spline_network.h"
#include "shared/core/ids.h"
#include "shared/core/state_hash.h"
#include "shared/math/types.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

struct StockDef {
    std::string good;
    float start = 0.0F;
    float high = 1e6F;   ///< stock stays between 0 and this
    float per_s = 0.0F;  ///< growth without trades
};

struct PointOfInterestDef {
    std::string name;
    Vec2d at = Vec2d::Zero();  ///< x, z, world coordinates, m
    float radius_m = 3.0F;     ///< each agent has a spot of its own within it
    std::vector<StockDef> stock;
    /// Height of the feet of an agent that stands there, m; NaN: on the ground.
    double y_m = std::numeric_limits<double>::quiet_NaN();
};

/// The points of interest of a world, for all its zones, and the length of a day.
struct PoiSettings {
    std::vector<PointOfInterestDef> points_of_interest;
    double day_s = 86400.0;
    double dawn_s = 0.0;                                     ///< time of day at tick 0
    std::shared_ptr<const splines::SplineNetwork> tracks{};  ///< null: there are none
};

/// One good in a trade: a variable of the agent, and the stock of the place.
struct TradeItem {
    std::uint16_t variable = 0;
    std::int16_t stock = -1;  ///< below 0: the place gives and takes it without limit
    float amount = 0.0F;      ///< gained by the agent; below 0: given by it
};

/// A trade is done as a whole or not at all.
struct Trade {
    std::uint16_t place = 0;
    std::vector<TradeItem> items;
};

/// A sense of a point of interest: the distance to the agent's spot, or its stock.
struct PointOfInterestSense {
    std::uint16_t place = 0;
    std::int16_t stock = -1;  ///< below 0: distance, m
    std::string name{};       ///< "PLACE.distance", "PLACE.GOOD"
};

/// The points of interest as one zone knows them. All of them have their position. Stock counts
/// only for places within the zone. Part of the zone's state.
class PointsOfInterest {
  public:
    PointsOfInterest() = default;
    /// `origin`: world coordinates x, z of the zone's (0, 0); `dt` in s, > 0.
    PointsOfInterest(const PoiSettings& settings, const Vec2d& origin, float dt);

    /// x, z of an entity's spot there, m: always the same, and uniform in the place's circle.
    [[nodiscard]] Vec2 spot(std::size_t place, EntityId entity) const;

    /// x, z of its centre, m.
    [[nodiscard]] Vec2 centre(std::size_t place) const { return places_[place].at; }

    /// m
    [[nodiscard]] float radius_m(std::size_t place) const { return places_[place].radius_m; }

    /// Height of the feet of an agent that stands there, m. NaN: on the ground, whatever is above
    /// the ground.
    [[nodiscard]] float floor(std::size_t place) const { return places_[place].y; }

    /// The distance of `at` (x, z, m) from the place's circle, m; 0 inside.
    [[nodiscard]] float outside(std::size_t place, const Vec2& at) const;

    /// The splines of the world, in its coordinates; null: there are none.
    [[nodiscard]] const splines::SplineNetwork* tracks() const { return tracks_.get(); }

    /// World coordinates x, z of (0, 0), m.
    [[nodiscard]] const Vec2d& origin() const { return origin_; }

    /// The stock at `now`.
    [[nodiscard]] float stock(std::size_t place, std::size_t stock, Tick now) const;

    /// Whether the place can do the trade at `now`.
    [[nodiscard]] bool can(const Trade& trade, Tick now) const;

    /// Does the trade; can() must be true for it.
    void commit(const Trade& trade, Tick now);

    /// s since the day began, in [0, day).
    [[nodiscard]] float time_of_day(Tick now) const;

    /// s
    [[nodiscard]] float day_s() const { return static_cast<float>(day_ticks_) * dt_; }

    void hash(core::StateHash& hash) const;

    struct Stock {
        float amount = 0.0F;  ///< at tick `at`; it grows since
        Tick at = 0;
        float per_tick = 0.0F;
        float high = 0.0F;
    };

    /// All stock of all points of interest, for snapshots.
    [[nodiscard]] std::span<const Stock> stocks() const { return stocks_; }

    /// `stocks` has as many elements as stocks().
    void set_stocks(std::span<const Stock> stocks) { stocks_.assign(stocks.begin(), stocks.end()); }

  private:
    struct PointOfInterest {
        Vec2 at = Vec2::Zero();
        float y = 0.0F;
        float radius_m = 0.0F;
        std::size_t first_stock = 0;
    };

    [[nodiscard]] float amount(const Stock& stock, Tick now) const;

    std::vector<PointOfInterest> places_;
    std::shared_ptr<const splines::SplineNetwork> tracks_;
    Vec2d origin_ = Vec2d::Zero();
    std::vector<Stock> stocks_;
    Tick day_ticks_ = 1;
    Tick dawn_ticks_ = 0;
    float dt_ = 1.0F;
};

}  // namespace zoned::ai
