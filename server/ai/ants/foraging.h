// Foraging: creatures that look for food and find the shortest way home by the scents they leave.
#pragma once

#include "server/ai/navigation/grid_map.h"
#include "shared/core/rng.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::ants {

struct ForagingSettings {
    float evaporation = 0.002F;  ///< share of all scent that is lost in a tick, 0 to 1
    float fade = 0.01F;          ///< by which a walker's mark gets weaker with each tick, 0 to 1
    float explore = 0.15F;       ///< share of those who leave home that no scent guides, 0 to 1
    std::uint32_t patience =
        3000;  ///< ticks without success after which a walker starts anew at home
    std::uint64_t seed = 1;
};

/// Scents on a map, and walkers that follow them. A walker that comes from home marks cells with
/// the scent of home, one that carries food with that of food: the weaker, the longer it has been
/// on its way, so that a scent grows towards where it comes from. A mark replaces a weaker one; all
/// evaporate, so that a way that is no longer walked is forgotten, and one that has become longer
/// is marked anew with what it is worth. Steps are chosen by chance, with weights after Deneubourg,
/// Aron, Goss and Pasteels, "The self-organizing exploratory pattern of the Argentine ant", Journal
/// of Insect Behavior 3, 1990, among the cells ahead; scouts go where no
/// scent leads until they find food. Deterministic by seed.
class Foraging {
  public:
    enum Scent : std::uint8_t {
        kHome,
        kFood,
        kScents
    };

    /// `map` must outlive this; it may change between steps. `home` is passable.
    Foraging(const navigation::GridMap& map,
             navigation::Cell home,
             const ForagingSettings& settings);

    /// Walkers start at home.
    void add_walkers(std::size_t count);

    /// Food that does not run out, or no more (`there` false).
    void set_food(navigation::Cell cell, bool there);

    /// Ticks that a step into this cell takes, >= 1 (mud, thicket). One at first.
    void set_slowness(navigation::Cell cell, std::uint8_t ticks);

    void step();

    /// 0 to 1.
    [[nodiscard]] float scent(Scent which, navigation::Place p) const { return scent_[which][p]; }

    [[nodiscard]] std::uint64_t delivered() const { return delivered_; }

    [[nodiscard]] std::size_t walkers() const { return at_.size(); }

    [[nodiscard]] navigation::Place walker_at(std::size_t i) const { return at_[i]; }

    [[nodiscard]] bool carries(std::size_t i) const { return carries_[i] != 0; }

  private:
    void evaporate();
    void walk(std::size_t i);
    void mark(std::size_t i);
    void set_out(std::size_t i);
    void turn_back(std::size_t i);
    [[nodiscard]] unsigned choose(std::size_t i);
    [[nodiscard]] float weight(std::size_t i, unsigned turn, bool guided) const;
    [[nodiscard]] bool open(navigation::Place from, unsigned direction) const;
    [[nodiscard]] navigation::Place beside(navigation::Place from, unsigned direction) const;

    const navigation::GridMap& map_;
    navigation::Place home_;
    ForagingSettings settings_;
    core::Rng rng_;
    std::array<std::vector<float>, kScents> scent_;
    std::vector<navigation::Place> scented_;  // cells with any scent
    std::vector<std::uint8_t> is_scented_;
    std::vector<std::uint8_t> food_;
    std::vector<std::uint8_t> slowness_;
    std::vector<float> strength_;  // of a mark, by ticks on the way
    unsigned sharpness_ = 0;       // how often ratios of scent are squared
    // Walkers.
    std::vector<navigation::Place> at_;
    std::vector<std::uint8_t> direction_;  // 0 to 7, by eighths of a turn
    std::vector<std::uint8_t> carries_;
    std::vector<std::uint8_t> scouts_;
    std::vector<std::uint8_t> busy_;     // ticks until the next step
    std::vector<std::uint32_t> on_way_;  // ticks since home or food
    std::uint64_t delivered_ = 0;
};

}  // namespace zoned::ai::ants
