// PointsOfInterest: where agents go to, what is in stock there, and the time of day.
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
    float high = 1e6F;   ///< it stays within 0 and this
    float per_s = 0.0F;  ///< growth by itself
};

struct PointOfInterestDef {
    std::string name;
    Vec2d at = Vec2d::Zero();  ///< x, z, world coordinates, m
    float radius_m = 3.0F;     ///< agents have spots of their own within it
    std::vector<StockDef> stock;
    /// Of the feet of who stands there, m; not a number: on the ground.
    double y_m = std::numeric_limits<double>::quiet_NaN();
};

/// The points of interest of a world, for all its zones, and how long a day takes.
struct PoiSettings {
    std::vector<PointOfInterestDef> points_of_interest;
    double day_s = 86400.0;
    double dawn_s = 0.0;                                     ///< time of day at tick 0
    std::shared_ptr<const splines::SplineNetwork> tracks{};  ///< null: there are none
};

/// One good in a trade: a variable of the agent, and where the place stocks it, which.
struct TradeItem {
    std::uint16_t variable = 0;
    std::int16_t stock = -1;  ///< below 0: the place has it, and takes it, without end
    float amount = 0.0F;      ///< that the agent gets; below 0: that it gives
};

/// All of it or nothing.
struct Trade {
    std::uint16_t place = 0;
    std::vector<TradeItem> items;
};

/// A sense of points of interest: how far the agent's spot is, or what is in stock.
struct PointOfInterestSense {
    std::uint16_t place = 0;
    std::int16_t stock = -1;  ///< below 0: distance, m
    std::string name{};       ///< "PLACE.distance", "PLACE.GOOD"
};

/// PointsOfInterest as one zone knows them: all of them by position, and stock, which counts where
/// the place lies in the zone alone. Part of the zone's state.
class PointsOfInterest {
  public:
    PointsOfInterest() = default;
    /// `origin`: world coordinates x, z of the zone's (0, 0); `dt` in s, > 0.
    PointsOfInterest(const PoiSettings& settings, const Vec2d& origin, float dt);

    /// x, z of the spot of an entity there: the same for ever, uniform in the place's circle.
    [[nodiscard]] Vec2 spot(std::size_t place, EntityId entity) const;

    /// x, z of its centre, m.
    [[nodiscard]] Vec2 centre(std::size_t place) const { return places_[place].at; }

    /// m
    [[nodiscard]] float radius_m(std::size_t place) const { return places_[place].radius_m; }

    /// Of the feet of who stands there, m; not a number: on the ground, whatever is above that.
    [[nodiscard]] float floor(std::size_t place) const { return places_[place].y; }

    /// How far `at` (x, z, m) is from the place's circle; 0 inside.
    [[nodiscard]] float outside(std::size_t place, const Vec2& at) const;

    /// The tracks of the world, in its coordinates; null: there are none.
    [[nodiscard]] const splines::SplineNetwork* tracks() const { return tracks_.get(); }

    /// World coordinates x, z of (0, 0), m.
    [[nodiscard]] const Vec2d& origin() const { return origin_; }

    /// What is in stock at `now`.
    [[nodiscard]] float stock(std::size_t place, std::size_t stock, Tick now) const;

    /// Whether the place can give and take this at `now`.
    [[nodiscard]] bool can(const Trade& trade, Tick now) const;

    /// Does it; can() must have said yes.
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

    /// As many as there are.
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
