#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/plain_rules.h"

namespace zoned {

std::shared_ptr<scenario::PlainLog>& plain_log() {
    static auto log = std::make_shared<scenario::PlainLog>();
    return log;
}

namespace zone {

std::unique_ptr<Rules> make_rules(const RulesSettings&, const world::TypeTable&) {
    return std::make_unique<scenario::PlainRules>(plain_log());
}

}  // namespace zone
}  // namespace zoned
