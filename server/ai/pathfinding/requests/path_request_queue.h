// PathRequestQueue: the common part of path providers over maps of nodes: requests, served in turn.
#pragma once

#include "server/ai/pathfinding/grid/corner_pool.h"
#include "server/ai/pathfinding/requests/path_provider.h"
#include "server/ai/pathfinding/requests/request_turns.h"
#include "shared/math/types.h"

#include <vector>

namespace zoned::ai::pathfinding {

struct QueueSettings {
    /// Work in a tick, in units of about 2 ns.
    std::uint64_t work_per_tick = 1'000'000;
    /// An asker with a single request gets its path after at most this many ticks, whatever the
    /// load.
    std::uint32_t longest_wait_ticks = 20;
};

/// A derived map locates nodes, finds paths, and decides which paths a change cuts. This class does
/// the rest: turns, the tick's work, corners, the progress of askers, and new searches after a
/// change.
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
    [[nodiscard]] RequestEnds ends(PathRequestId ticket) const final;

    [[nodiscard]] std::span<const std::uint32_t> answered() const final { return reported_; }

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

    /// FoundPath: a path as a search returns it.
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

    /// Finds the places of both ends on the map. kFound, or the reason why there are none.
    virtual PathOutcome locate(PathRequestEntry& request) = 0;

    /// Puts a path into `found`, whose vectors are empty, and adds its cost to spent(). `late`: the
    /// tick's work is used up.
    virtual void find(const PathRequestEntry& request, bool late, FoundPath& found) = 0;

    /// The point to walk to from a place while the path is not ready; moves `from` there.
    virtual Spot first_segment(PathRequestEntry& request, Spot at) const = 0;

    /// Prepares the tables that first_segment() reads, within the tick's work.
    virtual void prepare_segments(const PathRequestEntry& request) = 0;

    /// The numbers of nodes and hinges on the map.
    [[nodiscard]] virtual MapNumbers numbers() const = 0;

    /// See SavedPaths::tables. By default there are none.
    [[nodiscard]] virtual std::vector<std::uint32_t> tables() const = 0;
    virtual void make_table(std::uint32_t node) = 0;

    /// True if the hinge can be passed now.
    [[nodiscard]] virtual bool passable(const Hinge& hinge) const = 0;

    /// True if a path through the parts opened by the last change could be shorter than the rest of
    /// this path.
    [[nodiscard]] virtual bool may_be_shorter(const PathRequestEntry& request) const = 0;

    /// For a request without a path, or with one that ends short of its goal (kPartial). True if it
    /// may get nearer after the last change. The change joined its reachable part with more, or
    /// opened something nearer.
    [[nodiscard]] virtual bool may_come_nearer(const PathRequestEntry& request) const = 0;

    /// Call after a change of the map: looks for paths anew. `opened`: something became passable.
    void review(bool opened);

    void nothing_changed() { requeued_.clear(); }

    void spend(std::uint64_t units) { spent_ += units; }

    [[nodiscard]] bool work_left() const { return spent_ < settings_.work_per_tick; }

    /// The end of a usable request's path.
    [[nodiscard]] Spot end_of(const PathRequestEntry& request) const {
        return pool_.of(request.corners).back();
    }

    /// The length of the rest of a path, from where the asker was last seen.
    [[nodiscard]] float left_m(const PathRequestEntry& request) const;

    [[nodiscard]] std::size_t queue_bytes() const;

  private:
    [[nodiscard]] SavedRequest saved_request(std::uint32_t number) const;
    void load(const SavedRequest& memory);
    void wait(std::uint32_t number);
    void fail(std::uint32_t number, PathOutcome outcome);
    void done(std::uint32_t number);
    void free_blocks(PathRequestEntry& request);
    /// True if the path, ahead of its asker, crosses something that cannot be passed now.
    [[nodiscard]] bool cut(const PathRequestEntry& request) const;

    QueueSettings settings_;
    CornerPool pool_;
    BlockPool<Hinge> hinges_;
    RequestTurns queue_;
    std::vector<PathRequestEntry> requests_;
    std::vector<std::uint32_t> free_;
    std::vector<std::uint32_t> answered_;  // answered since the last serve()
    std::vector<std::uint32_t> reported_;  // reported by the last serve()
    std::vector<std::uint32_t> requeued_;
    std::vector<std::uint32_t> unled_;  // requests that wait since a change
    FoundPath found_;
    std::uint64_t spent_ = 0;
    PathCounts counts_;
};

}  // namespace zoned::ai::pathfinding
