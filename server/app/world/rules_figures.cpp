#include "server/app/world/rules_figures.h"

#include "server/zone/rules_context.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace zoned::app {

namespace {

constexpr std::size_t kLongestFigureName = 64;

bool is_name(std::string_view name) {
    return !name.empty() && name.size() <= kLongestFigureName &&
           std::ranges::all_of(name, [](char c) {
               return c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                      (c >= '0' && c <= '9');
           });
}

template <class Figures>
bool has_room(const Figures& figures, const typename Figures::key_type& key) {
    return figures.size() < zone::kMostRulesFigures || figures.contains(key);
}

}  // namespace

void RulesFigures::take(std::span<const zone::RulesFigure> figures, std::size_t zone) {
    for (const zone::RulesFigure& figure : figures) {
        const std::pair key(figure.name, zone);
        if (!is_name(figure.name) || !std::isfinite(figure.value) ||
            !(figure.counts ? has_room(counts, figure.name) : has_room(gauges, key))) {
            ++refused;
        } else if (figure.counts) {
            counts[figure.name] += figure.value;
        } else {
            gauges[key] = figure.value;
        }
    }
}

}  // namespace zoned::app
