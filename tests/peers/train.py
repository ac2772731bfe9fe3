"""Peer of `tests/bench train`: the same network, batch and optimiser in PyTorch, on the processor or on a GPU.

Input convolution 1 -> C with 2x2 max pooling, five blocks BN-ReLU-Conv-BN-ReLU-Conv with identity skip, mean over the
image, classifier; cross entropy, AdamW. Random 64 x 64 images. Prints one JSON object; times are of a step, averaged over about 500 images.
"""

import argparse
import json
import resource
import time

import torch
from torch import nn


# Images between two looks at the clock, about.
IMAGES = 500


class Block(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.norm1 = nn.BatchNorm2d(channels)
        self.conv1 = nn.Conv2d(channels, channels, 3, padding=1, bias=False)
        self.norm2 = nn.BatchNorm2d(channels)
        self.conv2 = nn.Conv2d(channels, channels, 3, padding=1)

    def forward(self, x):
        t = self.conv1(torch.relu(self.norm1(x)))
        return x + self.conv2(torch.relu(self.norm2(t)))


class Network(nn.Module):
    def __init__(self, channels, blocks, stride, classes):
        super().__init__()
        self.stem = nn.Conv2d(1, channels, 3, stride=stride, padding=1)
        self.blocks = nn.Sequential(*[Block(channels) for _ in range(blocks)])
        self.head = nn.Linear(channels, classes)

    def forward(self, x):
        x = torch.max_pool2d(self.stem(x), 2)
        return self.head(self.blocks(x).mean(dim=(2, 3)))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--batch", type=int, default=100)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--channels", type=int, default=16)
    parser.add_argument("--stem-stride", type=int, default=1)
    parser.add_argument("--epochs", type=int, default=10)
    parser.add_argument("--channels-last", action="store_true")
    parser.add_argument("--device", default="cpu")
    args = parser.parse_args()
    torch.manual_seed(1)
    torch.set_num_threads(args.threads)
    network = Network(args.channels, 5, args.stem_stride, 5)
    images, labels = torch.rand(args.batch, 1, 64, 64), torch.randint(0, 5, (args.batch,))
    if args.channels_last:
        network, images = network.to(memory_format=torch.channels_last), images.to(memory_format=torch.channels_last)
    network, images, labels = network.to(args.device), images.to(args.device), labels.to(args.device)
    optimizer = torch.optim.AdamW(network.parameters(), lr=5e-3, weight_decay=1e-4)

    def step():
        loss = nn.functional.cross_entropy(network(images), labels)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        loss.item()

    steps = max(1, IMAGES // args.batch)
    times = []
    for _ in range(args.epochs):
        before = time.perf_counter()
        for _ in range(steps):
            step()
        times.append((time.perf_counter() - before) / steps)
    times = sorted(times[1:])
    print(json.dumps({
        "least_ms": 1e3 * times[0],
        "median_ms": 1e3 * times[len(times) // 2],
        "samples_per_s": args.batch / times[0],
        "MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "torch": torch.__version__,
    }))


if __name__ == "__main__":
    main()
