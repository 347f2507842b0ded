# %% [markdown]
# # Sheer in Python
#
# Each cell stands for itself in a notebook; as a script it runs through. Pictures are small here, so that it
# takes seconds: `SIZE` is width and height.

# %%
import numpy as np
import sheer

SIZE = (160, 90)

# %% [markdown]
# ## A picture and its planes
#
# A scene is a built-in one, a file, or bytes of one. The planes are NumPy arrays of height by width, the top
# row first: the renderer's own memory, not copies.

# %%
square = sheer.open("smoke-square")
picture = sheer.render(square, "joint", aa="layered", size=SIZE, frames=8)
print(picture)
print("colour", picture.colour.shape, picture.colour.dtype, "linear, premultiplied")
print("depth ", picture.depth.shape, "from", picture.depth.min(), "along the viewing axis")
print("smoke or glass in", f"{picture.transparent.mean():.0%}", "of the pixels")
picture  # a notebook shows it

# %% [markdown]
# ## A scene of arrays
#
# A hundred thousand triangles: a wave, red where it is high, fading towards its rim.

# %%
n = 224
x, z = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1))
distance = np.hypot(x, z)
positions = np.stack([x, 0.2 * np.cos(9 * distance), z], axis=-1).reshape(-1, 3)
corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1, 1)
indices = np.concatenate([corner + [0, n + 1, 1], corner + [1, n + 1, n + 2]])
height = positions[:, 1] / 0.4 + 0.5
rgba = np.stack([height, 0.2 + 0 * height, 1 - height, np.clip(1.2 - distance.ravel(), 0, 1) * 0.6], axis=-1)

wave = sheer.Scene.from_arrays(positions, indices, rgba, name="wave")
print(wave, "in", wave.bounds)
camera = sheer.Camera(eye=(1.6, 1.1, 1.9), target=(0, 0, 0), fov=40)
wave_picture = sheer.render(wave, "std", size=SIZE, samples=16, camera=camera)
wave_picture.save("wave.png")  # sRGB; .exr keeps linear light and all planes

# %% [markdown]
# ## Over a background of one's own
#
# Colour is premultiplied: what lies behind is seen by `1 - alpha`.

# %%
glass = sheer.render(wave, size=SIZE, background="none", samples=8, camera=camera)
checks = (np.indices(glass.alpha.shape) // 8).sum(axis=0) % 2 * 0.5 + 0.25
over = glass.colour[..., :3] + (1 - glass.alpha[..., None]) * checks[..., None]
print("over checks", over.shape, f"of which {1 - glass.alpha.mean():.0%} is seen")

# %% [markdown]
# ## A clip
#
# Frames are rendered as they are asked for; Ctrl-C ends them.

# %%
for frame in sheer.sequence(wave, "joint", size=SIZE, frames=3, samples=4, camera="orbit"):
    print("frame", frame.info["frame"], "at", frame.info["time_secs"], "s, mean", frame.colour[..., :3].mean())

# %% [markdown]
# ## Methods against the exact answer
#
# The rows have the names of `sheer compare`'s report, a list of dicts: `pandas.DataFrame(rows)` is a table.

# %%
rows = sheer.compare(wave, ["std", "weighted"], aa="taa", size=SIZE, frames=4, camera=camera)
for row in rows:
    print(f"{row['method']:10} SSIM {row['ssim']:.4f}  FLIP {row['flip']:.4f}  bias {row['bias']:+.5f}")

# %% [markdown]
# ## Figures of pictures from anywhere
#
# SSIM, PSNR and FLIP take what a display shows, RMS and bias linear light.

# %%
reference = sheer.render(wave, "baseline", size=SIZE, samples=16, camera=camera)
print("SSIM", sheer.metrics.ssim(reference.displayed(), wave_picture.displayed()))
print("FLIP", sheer.metrics.flip(reference.displayed(), wave_picture.displayed()))
print("RMS ", sheer.metrics.rms(reference.colour[..., :3], wave_picture.colour[..., :3]))
