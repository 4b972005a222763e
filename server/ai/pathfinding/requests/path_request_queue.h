// PathRequestQueue: requests for paths over a map of nodes, served in turn: what all such maps
// share.
#pragma once

#include "server/ai/pathfinding/grid/corner_pool.h"
#include "server/ai/pathfinding/requests/path_provider.h"
#include "server/ai/pathfinding/requests/request_turns.h"
#include "shared/math/types.h"

#include <vector>

namespace zoned::ai::pathfinding {

struct QueueSettings {
    /// Of a tick, in units of about 2 ns.
    std::uint64_t work_per_tick = 1'000'000;
    /// Who has asked for one path alone has it after so many ticks, whatever the load.
    std::uint32_t longest_wait_ticks = 20;
};

/// A map says where nodes are, finds paths, and says what a change cuts; the rest is here: turns,
/// the tick's work, corners, who has come how far, and who looks anew after a change.
class PathRequestQueue : public PathProvider {
  public:
    explicit PathRequestQueue(const QueueSettings& settings);

    PathRequestId ask(const PathRequest& ask) final;
    void release(PathRequestId ticket) final;
    [[nodiscard]] bool knows(PathRequestId ticket) const final;
    void serve() final;
    [[nodiscard]] PathResult answer(PathRequestId ticket) const final;
    Spot heading(PathRequestId ticket, Spot at, float near_m) final;
    void see(PathRequestId ticket, Spot at, float at_y) final;

    [[nodiscard]] std::span<const std::uint32_t> answered() const final { return told_; }

    [[nodiscard]] std::span<const std::uint32_t> requeued() const final { return requeued_; }

    [[nodiscard]] SavedPaths save() const final;
    std::string load(const SavedPaths& memory) final;

    [[nodiscard]] const PathCounts& counts() const final { return counts_; }

  protected:
    static constexpr std::uint32_t kNoNode = ~0U;

    using End = PathEnd;
    using Hinge = pathfinding::Hinge;

    struct PathRequestEntry : RequestState {
        CornerBlock corners;
        CornerBlock hinges;
    };

    /// A path as it is found.
    struct FoundPath {
        PathOutcome outcome = PathOutcome::kFound;
        bool best = false;
        bool straight = false;
        bool cheap = false;  ///< from group to group
        double cost = 0.0;
        float short_m = 0.0F;          ///< RequestState::short_m
        std::uint32_t last = kNoNode;  ///< RequestState::last
        std::vector<Spot> corners;     ///< without the start
        std::vector<Hinge> hinges;
    };

    /// The places on the map of both ends. kFound, or why there are none.
    virtual PathOutcome locate(PathRequestEntry& request) = 0;

    /// Puts a path into `found`, whose vectors are empty, and adds what it cost to spent(). `late`:
    /// the tick's work is used up.
    virtual void find(const PathRequestEntry& request, bool late, FoundPath& found) = 0;

    /// Where to go from a place as long as the path is not there; moves `from` there.
    virtual Spot first_segment(PathRequestEntry& request, Spot at) const = 0;

    /// Makes ready what first_segment() looks up, as far as the tick's work goes.
    virtual void prepare_segments(const PathRequestEntry& request) = 0;

    /// How many nodes and hinges the map numbers.
    [[nodiscard]] virtual MapNumbers numbers() const = 0;

    /// See SavedPaths::tables. One is made for nothing.
    [[nodiscard]] virtual std::vector<std::uint32_t> tables() const = 0;
    virtual void make_table(std::uint32_t node) = 0;

    /// Whether one gets past this now.
    [[nodiscard]] virtual bool passable(const Hinge& hinge) const = 0;

    /// Whether a path through what the last change opened to where a path ends could be shorter
    /// than what is left of that.
    [[nodiscard]] virtual bool may_be_shorter(const PathRequestEntry& request) const = 0;

    /// Whether one that has no path, or a path that ends short of what was wanted (kPartial), may
    /// get nearer to it after the last change: what can be reached was joined with more by it, or
    /// it opened something nearer.
    [[nodiscard]] virtual bool may_come_nearer(const PathRequestEntry& request) const = 0;

    /// After a change of the map: looks for paths anew. `opened`: something can be passed that
    /// could not before.
    void review(bool opened);

    void nothing_changed() { requeued_.clear(); }

    void spend(std::uint64_t units) { spent_ += units; }

    [[nodiscard]] bool work_left() const { return spent_ < settings_.work_per_tick; }

    /// Of a request that is usable.
    [[nodiscard]] Spot end_of(const PathRequestEntry& request) const {
        return pool_.of(request.corners).back();
    }

    /// What is left of a path, from where the asker was last seen.
    [[nodiscard]] float left_m(const PathRequestEntry& request) const;

    [[nodiscard]] std::size_t queue_bytes() const;

  private:
    [[nodiscard]] SavedRequest saved_request(std::uint32_t number) const;
    void load(const SavedRequest& memory);
    void wait(std::uint32_t number);
    void fail(std::uint32_t number, PathOutcome outcome);
    void done(std::uint32_t number);
    void free_blocks(PathRequestEntry& request);
    /// Whether it leads, ahead of its asker, over something that can't be passed now.
    [[nodiscard]] bool cut(const PathRequestEntry& request) const;

    QueueSettings settings_;
    CornerPool pool_;
    BlockPool<Hinge> hinges_;
    RequestTurns queue_;
    std::vector<PathRequestEntry> requests_;
    std::vector<std::uint32_t> free_;
    std::vector<std::uint32_t> answered_;  // since the last serve()
    std::vector<std::uint32_t> told_;      // by it
    std::vector<std::uint32_t> requeued_;
    std::vector<std::uint32_t> unled_;  // that wait since a change
    FoundPath found_;
    std::uint64_t spent_ = 0;
    PathCounts counts_;
};

}  // namespace zoned::ai::pathfinding
