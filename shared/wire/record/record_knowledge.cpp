#include "shared/wire/record/record_knowledge.h"

#include <algorithm>

namespace zoned::wire::record {

namespace {

/// Over so many residuals the mean is taken.
constexpr float kMeanOf = 32.0F;
/// Before anything was learned, steps.
constexpr float kExpectedAtFirst = 4.0F;
constexpr float kExpectedFromNothing = 256.0F;

}  // namespace

// ---------------------------------------------------------------- bases

const CodedRecord* Bases::find(EntityId entity, ZoneId zone, entropy::PacketNumber newest) const {
    const auto it = versions_.find(entity);
    if (it == versions_.end()) {
        return nullptr;
    }
    const auto after =
        std::upper_bound(it->second.begin(),
                         it->second.end(),
                         newest,
                         [](entropy::PacketNumber n, const Version& v) { return n < v.number; });
    if (after == it->second.begin()) {
        return nullptr;
    }
    const Version& version = *std::prev(after);
    return version.record.remove || version.zone != zone ? nullptr : &version.record;
}

void Bases::learn(const RecordFrame& frame) {
    for (const CodedRecord& record : frame.records) {
        std::vector<Version>& versions = versions_[record.entity];
        if (!versions.empty() && versions.back().number >= frame.number) {
            continue;  // learned by another state of knowledge before
        }
        versions.push_back({frame.number, frame.zone, record});
        if (versions.size() > kVersions) {
            versions.erase(versions.begin());
        }
    }
}

// ---------------------------------------------------------------- models

RecordModels::RecordModels() {
    for (auto& by_reach : expected) {
        by_reach.fill(kExpectedAtFirst);
        by_reach[kFromNothing] = kExpectedFromNothing;
    }
    // What is the same before is the same again.
    bits.fill(entropy::BitModel(7u << 13));
}

void RecordModels::learn(const std::vector<RecordLesson>& lessons) {
    for (const RecordLesson& lesson : lessons) {
        if (lesson.model >= kFirstBit) {
            bits[lesson.model - kFirstBit].learn(lesson.symbol != 0);
        } else if (lesson.model >= kFirstSymbol) {
            symbols[lesson.model - kFirstSymbol].learn(lesson.symbol);
        } else {
            const std::size_t what = lesson.model / entropy::kScaleClasses;
            residuals[what].of(lesson.model % entropy::kScaleClasses).learn(lesson.symbol);
            float& mean = expected[what][lesson.reach];
            mean += (entropy::typical_magnitude(lesson.symbol) - mean) / kMeanOf;
        }
    }
}

// ---------------------------------------------------------------- knowledge

RecordKnowledge::RecordKnowledge(const RecordFormat& /*format*/)
    : bases_(std::make_shared<Bases>()) {
    velocity_.fill(entropy::LeastSquares<1>({1.0}));
}

void RecordKnowledge::learn(const std::shared_ptr<const RecordFrame>& frame) {
    models_.learn(frame->lessons);
    for (std::size_t i = 0; i < velocity_.size(); ++i) {
        if (frame->velocity[i].any) {
            velocity_[i].learn(frame->velocity[i]);
            velocity_[i].solve();
        }
    }
    bases_->learn(*frame);
    learned_.add(frame->number);
}

}  // namespace zoned::wire::record
