// Comparison: times several methods on one scene and writes their rows.
#pragma once

#include "tests/bench/suite.h"
#include "tests/bench/timing.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace zoned::bench {

inline constexpr float kStepTime = 1.0F / 60.0F;  ///< of scenes that move, s

/// A trial that fills its own row with the error, the metrics and the hash.
class JudgedTrial : public Trial {
  public:
    /// After the last frame of the observed run.
    virtual void judge(Row& row) = 0;
};

struct Method {
    std::string name;  ///< `default`, or an alternative's
    std::string peer;  ///< empty for ours
    std::function<std::unique_ptr<JudgedTrial>()> build;
};

/// "peer/method", or the method alone where it is ours.
std::string full_name(const std::string& method, const std::string& peer);

/// Rows of all methods on one scene, in their order. Each is judged and timed in turns, with the
/// metric bullet_ratio where Bullet's default is among them. `suite`, `scene` and `parameter` name
/// them.
std::vector<Row> compare(const std::string& suite,
                         const std::string& scene,
                         const std::string& parameter,
                         const std::vector<Method>& methods,
                         const Plan& plan);

/// The methods that the session asks for.
std::vector<Method> wanted(const Session& session, std::vector<Method> methods);

}  // namespace zoned::bench
