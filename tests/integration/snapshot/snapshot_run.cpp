#include "tests/integration/snapshot/snapshot_run.h"

#include "shared/core/rng.h"

#include <algorithm>
#include <chrono>

namespace zoned::snapshot {

namespace {

double milliseconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
        .count();
}

/// A world that goes on from a snapshot, and the tick up to which it is compared.
struct SnapshotCopy {
    std::unique_ptr<app::World> world;
    Tick from = 0;
    Tick until = 0;
};

class CourseRunner {
  public:
    CourseRunner(const harness::VirtualServer& server, SnapshotResult& result)
        : server_(server),
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
            if (copy.until <= original.now() && result_.wrong.empty()) {
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

    void copy(const app::World& original, Tick follows) {
        std::vector<std::uint8_t> bytes;
        bytes.reserve(warm_);
        auto begin = std::chrono::steady_clock::now();
        const std::string unsaved = original.save(bytes, &result_.sections);
        const double save_ms = milliseconds_since(begin);
        warm_ = std::max(warm_, bytes.size() * 2);
        if (!unsaved.empty()) {
            note("tick " + std::to_string(original.now()) + " is not saved: " + unsaved);
            return;
        }
        begin = std::chrono::steady_clock::now();
        auto world = std::make_unique<app::World>(server_.settings(), 1);
        const std::string unloaded = world->load(bytes);
        const double load_ms = milliseconds_since(begin);
        if (!unloaded.empty()) {
            note("tick " + std::to_string(original.now()) + " is not loaded: " + unloaded);
            return;
        }
        const std::string differs = compare(original, *world);
        if (!differs.empty()) {
            note("a loaded snapshot of tick " + std::to_string(original.now()) +
                 " is not saved as it was: " + differs);
            return;
        }
        const bool is_first = result_.copies++ == 0;
        result_.save_ms = is_first ? save_ms : std::min(result_.save_ms, save_ms);
        result_.load_ms = is_first ? load_ms : std::min(result_.load_ms, load_ms);
        result_.most_bytes = std::max(result_.most_bytes, bytes.size());
        copies_.push_back({std::move(world), original.now(), original.now() + follows});
    }

  private:
    static std::string compare(const app::World& a, const app::World& b) {
        std::vector<core::ArchiveSection> parts;
        std::vector<std::uint8_t> of_a;
        std::vector<std::uint8_t> of_b;
        std::string wrong = a.save(of_a, &parts);
        wrong = wrong.empty() ? b.save(of_b) : wrong;
        return wrong.empty() ? first_difference(of_a, parts, of_b) : wrong;
    }

    void note(std::string wrong) {
        if (result_.wrong.empty()) {
            result_.wrong = std::move(wrong);
        }
    }

    const harness::VirtualServer& server_;
    SnapshotResult& result_;
    std::vector<SnapshotCopy> copies_;
    std::vector<mailbox::OutboxItem> outbox_;
    std::vector<std::uint64_t> hashes_;
    std::vector<std::uint64_t> copied_;
    std::size_t warm_ = 0;
};

}  // namespace

std::string first_difference(const std::vector<std::uint8_t>& a,
                             const std::vector<core::ArchiveSection>& parts,
                             const std::vector<std::uint8_t>& b) {
    // The head holds a checksum, which differs with anything else.
    const std::size_t head = parts.empty() ? 0 : parts.front().begin;
    const std::size_t both = std::min(a.size(), b.size());
    std::size_t at = std::min(head, both);
    while (at < both && a[at] == b[at]) {
        ++at;
    }
    if (at == both && a.size() == b.size()) {
        return {};
    }
    std::string text = "byte " + std::to_string(at) + " of " + std::to_string(a.size()) + " and " +
                       std::to_string(b.size());
    const auto part = std::find_if(parts.begin(), parts.end(), [at](const auto& one) {
        return one.begin <= at && at < one.end;
    });
    return part == parts.end()
               ? text
               : text + ", " + part->name + "byte " + std::to_string(at - part->begin) + " of " +
                     std::to_string(part->end - part->begin);
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
    CourseRunner runner(server, result);
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
        if (left > 0 && seen >= due) {
            runner.copy(world, course.follows);
            --left;
            due = seen + course.every + rng.below(16);
        }
    }
    return result;
}

}  // namespace zoned::snapshot
