#include "server/rules/chat.h"

#include "shared/core/utf8.h"

namespace zoned::rules {

namespace {

bool is_own_team(const Actor& actor, const std::string& topic) {
    return !actor.record->team.empty() && topic == team_topic(actor.record->team);
}

}  // namespace

std::string team_topic(std::string_view team) {
    return "team/" + std::string(team);
}

std::string zone_topic(ZoneId zone) {
    return "zone/" + std::to_string(zone.value);
}

void chat(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Chat chat;
    if (!chat.ParseFromArray(payload.data(), static_cast<int>(payload.size())) ||
        chat.text().empty() || chat.text().size() > kMaxChatBytes ||
        !core::is_clean_utf8(chat.text())) {
        deny_malformed(game, context, actor);
        return;
    }
    if (chat.topic() != kWorldTopic && !is_own_team(actor, chat.topic()) &&
        chat.topic() != zone_topic(context.zone())) {
        deny(game, context, actor, "not your topic");
        return;
    }
    const Tick interval = ticks(context, 1.0F / game.settings.chat_per_s);
    const Tick burst = static_cast<Tick>(game.settings.chat_burst);
    if (!within_rate(actor.record->chat_due, context.now(), interval, burst)) {
        deny(game, context, actor, "too fast");
        return;
    }
    sandbox::ChatLine line;
    line.set_client(actor.client.value);
    line.set_name(actor.record->name);
    line.set_text(chat.text());
    context.publish(chat.topic(), event(sandbox::EVENT_CHAT, line));
    ++game.stats.chats;
}

void subscribe(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Subscribe subscribe;
    if (!subscribe.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    if (subscribe.topic() != kWorldTopic && !is_own_team(actor, subscribe.topic())) {
        deny(game, context, actor, "not your topic");
        return;
    }
    if (subscribe.on()) {
        context.subscribe(actor.client, subscribe.topic());
    } else {
        context.unsubscribe(actor.client, subscribe.topic());
    }
}

}  // namespace zoned::rules
