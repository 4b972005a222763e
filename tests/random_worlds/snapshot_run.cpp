#include "tests/random_worlds/snapshot_run.h"

#include "server/app/world/world.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace zoned::snapshot {

namespace {

/// More parts that differ than these tell no more.
constexpr std::size_t kMostNamed = 8;

double milliseconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
        .count();
}

/// A world that goes on from a snapshot, and the tick up to which it is compared.
struct SnapshotCopy {
    std::unique_ptr<app::World> world;
    Tick from = 0;
    Tick until = 0;
    int waited = 0;  ///< ticks beyond, in which the original refused to be saved
};

class CourseRunner {
  public:
    CourseRunner(const harness::VirtualServer& server, int longest_refusal, SnapshotResult& result)
        : server_(server),
          longest_refusal_(longest_refusal),
          result_(result) {}

    [[nodiscard]] bool any() const { return !copies_.empty(); }

    void follow(app::World& original) {
        for (SnapshotCopy& copy : copies_) {
            outbox_.clear();
            copy.world->tick(server_.last_items(), outbox_);
            original.hash_zones(hashes_);
            copy.world->hash_zones(copied_);
            result_.compared += hashes_.size();
            for (std::size_t z = 0; z < hashes_.size(); ++z) {
                if (hashes_[z] != copied_[z]) {
                    note("zone " + std::to_string(z + 1) + " differs at tick " +
                         std::to_string(original.now()) + ", " +
                         std::to_string(original.now() - copy.from) +
                         " after the snapshot; the states: " + compare(original, *copy.world));
                }
            }
            if (copy.until <= original.now() && copy.waited < longest_refusal_ &&
                refuses(original)) {
                ++copy.waited;
                copy.until = original.now() + 1;
            } else if (copy.until <= original.now() && result_.wrong.empty()) {
                const std::string differs = compare(original, *copy.world);
                if (!differs.empty()) {
                    note("hashes are equal, but at tick " + std::to_string(original.now()) + ", " +
                         std::to_string(original.now() - copy.from) +
                         " after the snapshot, the states differ: " + differs);
                }
            }
        }
        std::erase_if(copies_,
                      [&](const SnapshotCopy& copy) { return copy.until <= original.now(); });
    }

    /// False: the world has no saved form in this tick, but may have one soon.
    bool copy(const app::World& original, Tick follows) {
        std::vector<std::uint8_t> bytes;
        bytes.reserve(warm_);
        auto begin = std::chrono::steady_clock::now();
        const std::string unsaved = original.save(bytes, &result_.sections);
        const double save_ms = milliseconds_since(begin);
        warm_ = std::max(warm_, bytes.size() * 2);
        if (!unsaved.empty() && ++refused_ < longest_refusal_) {
            return false;
        }
        result_.refused = std::max(result_.refused, std::exchange(refused_, 0));
        if (!unsaved.empty()) {
            note("tick " + std::to_string(original.now()) + " is not saved: " + unsaved);
            return true;
        }
        begin = std::chrono::steady_clock::now();
        auto world = std::make_unique<app::World>(server_.settings(), 1);
        const std::string unloaded = world->load(bytes);
        const double load_ms = milliseconds_since(begin);
        if (!unloaded.empty()) {
            note("tick " + std::to_string(original.now()) + " is not loaded: " + unloaded);
            return true;
        }
        const std::string differs = compare(original, *world);
        if (!differs.empty()) {
            note("a loaded snapshot of tick " + std::to_string(original.now()) +
                 " is not saved as it was: " + differs);
            return true;
        }
        const bool is_first = result_.copies++ == 0;
        result_.save_ms = is_first ? save_ms : std::min(result_.save_ms, save_ms);
        result_.load_ms = is_first ? load_ms : std::min(result_.load_ms, load_ms);
        result_.most_bytes = std::max(result_.most_bytes, bytes.size());
        copies_.push_back({std::move(world), original.now(), original.now() + follows});
        return true;
    }

  private:
    static bool refuses(const app::World& world) {
        std::vector<std::uint8_t> bytes;
        return !world.save(bytes).empty();
    }

    static std::string compare(const app::World& a, const app::World& b) {
        std::vector<core::ArchiveSection> parts_of_a;
        std::vector<core::ArchiveSection> parts_of_b;
        std::vector<std::uint8_t> of_a;
        std::vector<std::uint8_t> of_b;
        std::string wrong = a.save(of_a, &parts_of_a);
        wrong = wrong.empty() ? b.save(of_b, &parts_of_b) : wrong;
        return wrong.empty() ? differences(of_a, parts_of_a, of_b, parts_of_b) : wrong;
    }

    void note(std::string wrong) {
        if (result_.wrong.empty()) {
            result_.wrong = std::move(wrong);
        }
    }

    const harness::VirtualServer& server_;
    int longest_refusal_;
    SnapshotResult& result_;
    std::vector<SnapshotCopy> copies_;
    std::vector<mailbox::OutboxItem> outbox_;
    std::vector<std::uint64_t> hashes_;
    std::vector<std::uint64_t> copied_;
    std::size_t warm_ = 0;
    int refused_ = 0;  // ticks in a row
};

}  // namespace

std::string differences(const std::vector<std::uint8_t>& a,
                        const std::vector<core::ArchiveSection>& parts_of_a,
                        const std::vector<std::uint8_t>& b,
                        const std::vector<core::ArchiveSection>& parts_of_b) {
    // The head holds a checksum, which differs with anything else.
    const std::size_t head = parts_of_a.empty() ? 0 : parts_of_a.front().begin;
    if (a.size() == b.size() && std::equal(a.begin() + static_cast<std::ptrdiff_t>(head),
                                           a.end(),
                                           b.begin() + static_cast<std::ptrdiff_t>(head))) {
        return {};
    }
    std::string text = std::to_string(a.size()) + " and " + std::to_string(b.size()) + " bytes";
    std::size_t named = 0;
    for (const core::ArchiveSection& part : parts_of_a) {
        // Outer parts come after their inner ones, which say more.
        const bool told = text.find("; " + part.name) != std::string::npos;
        const auto other = std::find_if(parts_of_b.begin(),
                                        parts_of_b.end(),
                                        [&part](const auto& one) { return one.name == part.name; });
        if (told || named == kMostNamed) {
            continue;
        }
        if (other == parts_of_b.end()) {
            text += "; " + part.name + "not there";
            ++named;
            continue;
        }
        const std::size_t size = part.end - part.begin;
        const std::size_t other_size = other->end - other->begin;
        std::size_t at = 0;
        while (at < std::min(size, other_size) && a[part.begin + at] == b[other->begin + at]) {
            ++at;
        }
        if (at < std::max(size, other_size)) {
            text += "; " + part.name + "byte " + std::to_string(at) + " of " +
                    std::to_string(size) + " and " + std::to_string(other_size);
            ++named;
        }
    }
    return text;
}

SnapshotResult run_course(const SnapshotCourse& course) {
    harness::VirtualServerSettings settings;
    settings.config = course.config;
    settings.config_is_text = course.config_is_text;
    settings.sets = course.sets;
    settings.network.loss = 0.02;
    settings.network.delay_s = 0.02;
    settings.network.jitter_s = 0.01;
    settings.network.seed = course.seed;
    settings.step_s = 1.0 / 240.0;
    app::SwarmSettings bots;
    bots.bots = course.bots;
    bots.seed = course.seed;
    bots.seconds = 3600.0;
    SnapshotResult result;
    harness::VirtualServer server(settings);
    app::Swarm swarm(bots, [&](std::size_t) { return server.connect(); });
    core::Rng rng(course.seed);
    CourseRunner runner(server, course.longest_refusal, result);
    Tick due = course.first + rng.below(16);
    int left = course.snapshots;
    Tick seen = 0;
    while ((left > 0 || runner.any()) && result.wrong.empty()) {
        server.step();
        swarm.advance(server.client_time_s());
        app::World& world = server.world();
        if (world.now() == seen) {
            continue;
        }
        seen = world.now();
        runner.follow(world);
        if (left > 0 && seen >= due && runner.copy(world, course.follows)) {
            --left;
            due = seen + course.every + rng.below(16);
        }
    }
    return result;
}

}  // namespace zoned::snapshot
