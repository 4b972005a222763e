#include "server/ai/fsm/diagram.h"

#include <array>
#include <cstdio>

namespace zoned::ai::fsm {

namespace {

/// A string in quotes, as dot wants it.
std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            out += '\\';
        }
        out += c;
    }
    return out + "\"";
}

std::string number(float value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%g", static_cast<double>(value));
    return text.data();
}

class Drawing {
  public:
    explicit Drawing(std::span<const std::string> senses) : senses_(senses) {}

    std::string draw(const MachineDef& def) {
        text_ = "digraph " + quoted(def.name) + " {\n";
        text_ += "  compound=true;\n  label=" + quoted(def.name) + ";\n";
        text_ += "  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n";
        text_ += "  edge [fontname=\"sans-serif\", fontsize=10];\n";
        states(def.states, "", "  ");
        text_ += "}\n";
        return text_;
    }

  private:
    void states(const std::vector<StateDef>& states,
                const std::string& prefix,
                const std::string& indent) {
        for (const StateDef& state : states) {
            const std::string name = prefix + state.name;
            if (state.inside.empty()) {
                text_ += indent + quoted(name) + " [label=" + quoted(state.name) + "];\n";
                continue;
            }
            const char* const mark = state.history == History::kDeep      ? "  (H*)"
                                     : state.history == History::kShallow ? "  (H)"
                                                                          : "";
            text_ += indent + "subgraph " + quoted("cluster_" + name) + " {\n";
            text_ += indent + "  label=" + quoted(state.name + mark) + ";\n";
            this->states(state.inside, name + "/", indent + "  ");
            text_ += indent + "}\n";
        }
        const std::string start = prefix + "*";
        text_ += indent + quoted(start) + " [shape=point, width=0.12, label=\"\"];\n" + indent +
                 quoted(start) + " -> " + quoted(within(states[0], prefix)) +
                 frame("lhead", states[0], prefix, " [", "]") + ";\n";
        for (const StateDef& state : states) {
            for (const TransitionDef& transition : state.transitions) {
                arrow(state, states[transition.to], transition, prefix, indent);
            }
        }
    }

    void arrow(const StateDef& from,
               const StateDef& to,
               const TransitionDef& transition,
               const std::string& prefix,
               const std::string& indent) {
        text_ += indent + quoted(within(from, prefix)) + " -> " + quoted(within(to, prefix)) +
                 " [label=" + quoted(label(transition));
        text_ += frame("ltail", from, prefix, ", ", "") + frame("lhead", to, prefix, ", ", "");
        text_ += "];\n";
    }

    /// A state that arrows can be tied to: itself, or the first within.
    static std::string within(const StateDef& state, const std::string& prefix) {
        const std::string name = prefix + state.name;
        return state.inside.empty() ? name : within(state.inside[0], name + "/");
    }

    static std::string frame(const char* end,
                             const StateDef& state,
                             const std::string& prefix,
                             const char* before,
                             const char* after) {
        return state.inside.empty()
                   ? std::string()
                   : before + (end + ("=" + quoted("cluster_" + prefix + state.name))) + after;
    }

    [[nodiscard]] std::string label(const TransitionDef& transition) const {
        std::string label;
        for (const Condition& condition : transition.when) {
            label += label.empty() ? "" : " and ";
            label += condition.sense == kStateTime      ? "time in state"
                     : condition.sense < senses_.size() ? senses_[condition.sense]
                                                        : "?";
            label += condition.compare == Compare::kBelow ? " < " : " > ";
            label += number(condition.threshold);
        }
        return transition.hold_s > 0.0F ? label + " for " + number(transition.hold_s) + " s"
                                        : label;
    }

    std::span<const std::string> senses_;
    std::string text_;
};

}  // namespace

std::string dot_of(const MachineDef& def, std::span<const std::string> senses) {
    return Drawing(senses).draw(def);
}

}  // namespace zoned::ai::fsm
