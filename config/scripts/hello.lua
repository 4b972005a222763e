-- Moves on joins and chats; a first sign of life.
function on_start() state.joins = 0 end
function on_join(client, avatar, name)
  state.joins = state.joins + 1
  print(name .. " joined as entity " .. avatar)
end
function on_leave(client, avatar) despawn(avatar) end
function on_command(client, avatar, kind, payload)
  announce(avatar, 18, payload)
end
function on_tick()
  for _, avatar in ipairs(avatars()) do
    local own = entity_state(avatar)
    own.ticks = (own.ticks or 0) + 1
  end
end
