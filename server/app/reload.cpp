#include "server/app/reload.h"

#include "server/ops/reload.h"

#include <utility>

namespace zoned::app {

namespace {

using Fresh = core::Result<mailbox::NewMinds>;

Fresh minds_of(const ops::Settings& fresh, const ops::Settings& running) {
    auto minds = ops::new_minds(running, fresh);
    if (!minds.ok()) {
        return Fresh::failure(minds.error());
    }
    return mailbox::NewMinds{std::make_shared<const std::string>(fresh.text), *minds};
}

}  // namespace

Fresh read_minds(const std::string& file,
                 const std::vector<std::string>& sets,
                 const ops::Settings& running) {
    ops::Settings fresh;
    std::vector<ops::ConfigError> errors;
    if (!ops::load_settings(file, sets, fresh, errors)) {
        return Fresh::failure(ops::format_errors(file, errors));
    }
    return minds_of(fresh, running);
}

core::Result<bool> restore_minds(const ops::Settings& running, mailbox::InboxItem& item) {
    auto* minds = std::get_if<mailbox::NewMinds>(&item);
    if (minds == nullptr || minds->minds != nullptr) {
        return true;
    }
    ops::Settings fresh;
    std::vector<ops::ConfigError> errors;
    if (!ops::parse_settings(*minds->config, {}, fresh, errors)) {
        return core::Result<bool>::failure(
            ops::format_errors("the config that was read anew", errors));
    }
    Fresh read = minds_of(fresh, running);
    if (!read.ok()) {
        return core::Result<bool>::failure(read.error());
    }
    *minds = std::move(*read);
    return true;
}

}  // namespace zoned::app
