#include "server/ai/decision/state_machine/state_diagram.h"

#include <array>
#include <cstdio>

namespace zoned::ai::state_machine {

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

    std::string draw(const StateMachineDef& def) {
        text_ = "digraph " + quoted(def.name) + " {\n";
        const char* const by_code = def.coded ? " (transitions by code)" : "";
        text_ += "  label=" + quoted(def.name + by_code) + ";\n";
        text_ += "  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n";
        text_ += "  edge [fontname=\"sans-serif\", fontsize=10];\n";
        text_ += "  \"*\" [shape=point, width=0.12, label=\"\"];\n";
        states(def.states, "", "*", "  ");
        text_ += "}\n";
        return text_;
    }

  private:
    /// `start`: where the arrow to the first of them comes from.
    void states(const std::vector<StateDef>& states,
                const std::string& prefix,
                const std::string& start,
                const std::string& indent) {
        for (const StateDef& state : states) {
            const std::string name = prefix + state.name;
            if (state.inside.empty()) {
                text_ += indent + quoted(name) + " [label=" + quoted(state.name) + "];\n";
                continue;
            }
            const char* const mark = state.history == StateHistory::kDeep      ? " (H*)"
                                     : state.history == StateHistory::kShallow ? " (H)"
                                                                               : "";
            text_ += indent + "subgraph " + quoted("cluster_" + name) + " {\n";
            text_ += indent + "  label=\"\";\n";
            text_ += indent + "  " + quoted(name) + " [label=" + quoted(state.name + mark) +
                     ", shape=tab, style=filled, fillcolor=lightgrey];\n";
            this->states(state.inside, name + "/", name, indent + "  ");
            text_ += indent + "}\n";
        }
        text_ += indent + quoted(start) + " -> " + quoted(prefix + states[0].name) +
                 " [style=dashed];\n";
        for (const StateDef& state : states) {
            for (const TransitionDef& transition : state.transitions) {
                text_ += indent + quoted(prefix + state.name) + " -> " +
                         quoted(prefix + states[transition.to].name) +
                         " [label=" + quoted(label(transition)) + "];\n";
            }
        }
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

std::string dot_of(const StateMachineDef& def, std::span<const std::string> senses) {
    return Drawing(senses).draw(def);
}

}  // namespace zoned::ai::state_machine
