#include "server/ai/agent/brain/points_of_interest.h"

#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

PointsOfInterest::PointsOfInterest(const PoiSettings& settings, const Vec2d& origin, float dt)
    : tracks_(settings.tracks),
      origin_(origin),
      day_ticks_(std::max<Tick>(1, std::llround(settings.day_s / static_cast<double>(dt)))),
      dawn_ticks_(std::llround(settings.dawn_s / static_cast<double>(dt))),
      dt_(dt) {
    for (const PointOfInterestDef& def : settings.points_of_interest) {
        PointOfInterest place;
        place.at = (def.at - origin).cast<float>();
        place.y = static_cast<float>(def.y_m);
        place.radius_m = def.radius_m;
        place.first_stock = stocks_.size();
        for (const StockDef& stock : def.stock) {
            stocks_.push_back({stock.start, 0, stock.per_s * dt, stock.high});
        }
        places_.push_back(place);
    }
}

Vec2 PointsOfInterest::spot(std::size_t place, EntityId entity) const {
    core::Rng rng(place, entity.value);
    Vec2 offset = Vec2::Zero();
    // Rejection from the square needs no trigonometry.
    do {
        offset.x() = rng.range(-1.0F, 1.0F);
        offset.y() = rng.range(-1.0F, 1.0F);
    } while (offset.squaredNorm() > 1.0F);
    return places_[place].at + offset * places_[place].radius_m;
}

float PointsOfInterest::outside(std::size_t place, const Vec2& at) const {
    return std::max(0.0F, (places_[place].at - at).norm() - places_[place].radius_m);
}

float PointsOfInterest::amount(const Stock& stock, Tick now) const {
    return std::clamp(
        stock.amount + stock.per_tick * static_cast<float>(now - stock.at), 0.0F, stock.high);
}

float PointsOfInterest::stock(std::size_t place, std::size_t stock, Tick now) const {
    return amount(stocks_[places_[place].first_stock + stock], now);
}

bool PointsOfInterest::can(const Trade& trade, Tick now) const {
    return std::all_of(trade.items.begin(), trade.items.end(), [&](const TradeItem& item) {
        if (item.stock < 0) {
            return true;
        }
        const Stock& stock =
            stocks_[places_[trade.place].first_stock + static_cast<std::size_t>(item.stock)];
        const float left = amount(stock, now) - item.amount;
        return left >= 0.0F && left <= stock.high;
    });
}

void PointsOfInterest::commit(const Trade& trade, Tick now) {
    for (const TradeItem& item : trade.items) {
        if (item.stock >= 0) {
            Stock& stock =
                stocks_[places_[trade.place].first_stock + static_cast<std::size_t>(item.stock)];
            stock.amount = amount(stock, now) - item.amount;
            stock.at = now;
        }
    }
}

float PointsOfInterest::time_of_day(Tick now) const {
    return static_cast<float>((now + dawn_ticks_) % day_ticks_) * dt_;
}

void PointsOfInterest::hash(core::StateHash& hash) const {
    for (const Stock& stock : stocks_) {
        hash.add(stock.amount);
        hash.add(stock.at);
    }
}

}  // namespace zoned::ai
