// The acceleration structure of the driver: static and moving triangles are an instance each, in world.
enable wgpu_ray_query;

@group(GROUP_SCENE) @binding(BIND_ACCEL) var scene_accel: acceleration_structure;
// Triangle of each primitive; an instance's custom data is the index of its first.
@group(GROUP_SCENE) @binding(BIND_ACCEL_TRIANGLES) var<storage, read> order: array<u32>;
